"""Emulated boards on a bench: what a test writes to them and reads from them."""

from __future__ import annotations

from collections.abc import Mapping

from sim.hat.devices.device import Device
from sim.hat.devices.lego_motor import LegoMotor
from sim.hat.devices.motor_kinds import kind_named
from sim.hat.devices.plants import FreeMotors
from sim.hat.emulated_board import EmulatedBoard

LARGE = 0x4C
COMBINED = "combi 0 1 0 2 0 3 0;select 0;selrate 10"


class Bench:
    """A board with free motors; large motors are plugged into the first ports."""

    def __init__(
        self,
        motors: int = 1,
        warm: bool = True,
        others: Mapping[int, Device] | None = None,
        seed: int = 0,
    ) -> None:
        self.plants = FreeMotors({port: kind_named("large") for port in range(4)})
        self.motors = [LegoMotor(LARGE, self.plants.plant(port)) for port in range(motors)]
        devices: dict[int, Device] = dict(enumerate(self.motors))
        self.board = EmulatedBoard(self.plants, devices | dict(others or {}), warm=warm, seed=seed)
        self._cut = b""
        """The start of a line that has not ended."""

    def say(self, line: str | bytes, seconds: float = 0.05) -> bytes:
        """What the board answers a line, to which a CR is added, within a time [s]."""
        data = line.encode() if isinstance(line, str) else line
        self.board.receive(data + b"\r")
        heard = self.board.advance(seconds)
        self._cut = heard.rpartition(b"\n")[2]
        return heard

    def lines(self, seconds: float) -> list[str]:
        """The whole lines that end from now on within a time [s], without blank ones."""
        heard, _, self._cut = (self._cut + self.board.advance(seconds)).rpartition(b"\n")
        return [line for line in heard.decode().replace("\r", "").split("\n") if line]

    def until(self, text: str, limit: float) -> float:
        """Time [s] until the board has printed something; fails after ``limit``.

        The line that it is in is read to its end.
        """
        start, heard, found = self.board.now, self._cut, 0.0
        while text.encode() not in heard:
            assert self.board.now - start < limit, f"no {text!r} within {limit} s, but {heard!r}"
            heard += self.board.advance(0.001)
            found = self.board.now - start
        while b"\n" not in heard[heard.index(text.encode()) + len(text) - 1 :]:
            heard += self.board.advance(0.001)
        self._cut = heard[heard.index(b"\n", heard.index(text.encode()) + len(text) - 1) + 1 :]
        return found

    def duties(self, count: int, port: int = 0) -> list[float | None]:
        """What the driver puts out in as many 10 ms ticks from now on."""
        duties = []
        for _ in range(count):
            self.board.advance(0.01)
            duties.append(self.board.duty(port))
        return duties

    def steps(self, count: int, port: int = 0) -> list[int | None]:
        """The same in steps of the driver chip, -255..255."""
        return [None if duty is None else round(duty * 255) for duty in self.duties(count, port)]
