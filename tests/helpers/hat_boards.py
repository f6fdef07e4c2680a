"""Emulated boards on a bench: what a test writes to them and reads from them."""

from __future__ import annotations

from sim.hat.emulated_board import EmulatedBoard
from sim.hat.lego_motor import LegoMotor
from sim.hat.motor_figures import figures_named
from sim.hat.plants import FreeMotors

LARGE = 0x4C
COMBINED = "combi 0 1 0 2 0 3 0;select 0;selrate 10"

LISTED_BLOCK = """P0: connected to active ID 4C
type 4C
  nmodes =5
  nview  =3
  baud   =115200
  hwver  =00000004
  swver  =10000000
  M0 POWER SI = PCT
    format count=1 type=0 chars=4 dp=0
    RAW: 00000000 00000064    PCT: 00000000 00000064    SI: 00000000 00000064
  M1 SPEED SI = PCT
    format count=1 type=0 chars=4 dp=0
    RAW: 00000000 00000064    PCT: 00000000 00000064    SI: 00000000 00000064
  M2 POS SI = DEG
    format count=1 type=2 chars=11 dp=0
    RAW: 00000000 00000168    PCT: 00000000 00000064    SI: 00000000 00000168
  M3 APOS SI = DEG
    format count=1 type=1 chars=3 dp=0
    RAW: 00000000 000000B3    PCT: 00000000 000000C8    SI: 00000000 000000B3
  M4 CALIB SI = CAL
    format count=2 type=1 chars=5 dp=0
    RAW: 00000000 00000E10    PCT: 00000000 00000064    SI: 00000000 00000E10
  M5 STATS SI = MIN
    format count=14 type=1 chars=5 dp=0
    RAW: 00000000 0000FFFF    PCT: 00000000 00000064    SI: 00000000 0000FFFF
  C0: M1+M2+M3
     speed PID: 00000BB8 00000064 00002328 00000438
  position PID: 00002EE0 000003E8 00013880 00000000
"""
"""What ``list`` prints of a large angular motor at port A, with LF for CR LF."""


class Bench:
    """A board with free motors; large motors are plugged into the first ports."""

    def __init__(
        self,
        motors: int = 1,
        warm: bool = True,
        seed: int = 0,
    ) -> None:
        self.plants = FreeMotors({port: figures_named("large") for port in range(4)})
        self.motors = [LegoMotor(LARGE, self.plants.plant(port)) for port in range(motors)]
        self.board = EmulatedBoard(self.plants, dict(enumerate(self.motors)), warm=warm, seed=seed)
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
