"""One-line commands that act on the board like a person's hands, or show its state."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Collection
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

from robot.description.wiring import PORTS
from robot.errors import BrickPoseError, CommandError
from robot.geometry import Pose2
from sim.hat.lego_motor import LegoMotor
from sim.hat.motor_figures import MOTOR_FIGURES, figures_named
from sim.hat_emulator.emulator import Emulator


@runtime_checkable
class Turnable(Protocol):
    """A motor whose shaft can be blocked and loaded."""

    stalled: bool
    """Whether something blocks it."""
    load: float
    """Torque [N m] that turns it anticlockwise."""


@dataclass(frozen=True)
class Command:
    """A command: its arguments and its action."""

    arguments: str
    """Its arguments, as ``help`` shows them."""
    counts: Collection[int]
    """Valid numbers of arguments."""
    do: Callable[[list[str]], str]
    """Executes it with the arguments, and returns the answer."""


class Control:
    """Answers command lines; each answer is one line: "ok", the requested data or "error: ..."."""

    def __init__(self, emulator: Emulator) -> None:
        self._emulator = emulator
        self._commands = {
            "unplug": Command("PORT", (1,), self._unplug),
            "plug": Command("PORT [MOTOR]", (1, 2), self._plug),
            "slow": Command("PORT SECONDS", (2,), self._slow),
            "stall": Command("PORT", (1,), self._stall),
            "free": Command("PORT", (1,), self._free),
            "load": Command("PORT NEWTON_METRES", (2,), self._load),
            "mute": Command("PORT on|off", (2,), self._mute),
            "setup": Command("PORT framing|checksum|silence", (2,), self._setup),
            "errors": Command("PORT", (1,), self._errors),
            "fault": Command("motor|port on|off", (2,), self._fault),
            "supply": Command("VOLTS", (1,), self._supply),
            "silent": Command("on|off", (1,), self._silent),
            "garble": Command("PROBABILITY", (1,), self._garble),
            "garble-in": Command("PROBABILITY", (1,), self._garble_in),
            "lose": Command("PROBABILITY", (1,), self._lose),
            "late": Command("MILLISECONDS", (1,), self._late),
            "say": Command("TEXT", range(1, sys.maxsize), self._say),
            "firmware": Command("VERSION", (1,), self._firmware),
            "reset": Command("", (0,), self._reset),
            "bootloader": Command("", (0,), self._reset),
            "place": Command("X Y THETA", (3,), self._place),
            "truth": Command("", (0,), self._truth),
            "duty": Command("", (0,), self._duty),
            "state": Command("", (0,), self._state),
            "help": Command("", (0,), self._help),
        }

    def answer(self, line: str) -> str:
        """Execute a line of words separated by blanks; return the answer."""
        try:
            return self._do(line.split())
        except BrickPoseError as error:
            return f"error: {error}"

    def _do(self, words: list[str]) -> str:
        if not words or words[0] not in self._commands:
            name = words[0] if words else ""
            raise CommandError(f"no command {name!r}; valid are {', '.join(self._commands)}")
        name, *arguments = words
        command = self._commands[name]
        if len(arguments) not in command.counts:
            raise CommandError(f"valid is: {name} {command.arguments}".rstrip())
        return command.do(arguments)

    def _unplug(self, words: list[str]) -> str:
        port, board = _port(words[0]), self._emulator.board
        if port not in board.devices:
            raise CommandError(f"nothing is plugged in at {PORTS[port]}")
        self._emulator.unplugged[port] = board.devices[port]
        board.unplug(port)
        return "ok"

    def _plug(self, words: list[str]) -> str:
        emulator, port = self._emulator, _port(words[0])
        device: LegoMotor
        if len(words) == 2:
            device = emulator.motor(port, figures_named(words[1]))
        elif port in emulator.unplugged:
            device = emulator.unplugged[port]
        else:
            names = ", ".join(figures.name for figures in MOTOR_FIGURES.values())
            raise CommandError(f"nothing was unplugged at {PORTS[port]}; say what, of {names}")
        emulator.board.plug(port, device)
        return "ok"

    def _slow(self, words: list[str]) -> str:
        port, seconds = _port(words[0]), _number(words[1], 0, 60)
        emulator = self._emulator
        device = emulator.board.devices.get(port) or emulator.unplugged.get(port)
        if device is None:
            raise CommandError(f"nothing is plugged in at {PORTS[port]}")
        device.connect_seconds = seconds
        return "ok"

    def _stall(self, words: list[str]) -> str:
        self._motor(words[0]).stalled = True
        return "ok"

    def _free(self, words: list[str]) -> str:
        motor = self._motor(words[0])
        motor.stalled, motor.load = False, 0.0
        return "ok"

    def _load(self, words: list[str]) -> str:
        self._motor(words[0]).load = _number(words[1], -10, 10)
        return "ok"

    def _mute(self, words: list[str]) -> str:
        port = _port(words[0])
        if port not in self._emulator.board.devices:
            raise CommandError(f"nothing is plugged in at {PORTS[port]}")
        self._emulator.board.devices[port].responding = not _switch(words[1])
        return "ok"

    def _setup(self, words: list[str]) -> str:
        self._emulator.board.setup_fails(_port(words[0]), words[1])
        return "ok"

    def _errors(self, words: list[str]) -> str:
        self._emulator.board.data_fails(_port(words[0]))
        return "ok"

    def _fault(self, words: list[str]) -> str:
        present = _switch(words[1])
        if words[0] == "motor":
            self._emulator.board.power.motor_fault = present
        elif words[0] == "port":
            self._emulator.board.power.port_fault = present
        else:
            raise CommandError(f"no fault {words[0]!r}; valid are motor, port")
        return "ok"

    def _supply(self, words: list[str]) -> str:
        self._emulator.board.supply_v = _number(words[0], 0, 18)
        return "ok"

    def _silent(self, words: list[str]) -> str:
        self._emulator.board.silent = _switch(words[0])
        return "ok"

    def _garble(self, words: list[str]) -> str:
        self._emulator.board.garble = _number(words[0], 0, 1)
        return "ok"

    def _garble_in(self, words: list[str]) -> str:
        self._emulator.board.garble_in = _number(words[0], 0, 1)
        return "ok"

    def _lose(self, words: list[str]) -> str:
        self._emulator.board.loss = _number(words[0], 0, 1)
        return "ok"

    def _late(self, words: list[str]) -> str:
        self._emulator.board.late(round(_number(words[0], 1, 1000)))
        return "ok"

    def _say(self, words: list[str]) -> str:
        """Print a text; errors of the inner bus, ``<like this>``, have no line end."""
        text = " ".join(words)
        self._emulator.board.print_text(text if text.endswith(">") else f"{text}\r\n")
        return "ok"

    def _firmware(self, words: list[str]) -> str:
        self._emulator.restart(round(_number(words[0], 1, 2**31)))
        return "ok"

    def _reset(self, words: list[str]) -> str:
        self._emulator.board.reset()
        return "ok"

    def _place(self, words: list[str]) -> str:
        x, y, theta = (_number(word, -1000, 1000) for word in words)
        self._emulator.surroundings.place(Pose2(x, y, theta))
        return "ok"

    def _truth(self, words: list[str]) -> str:
        pose = self._emulator.surroundings.truth
        return f"{pose.x:z.6f} {pose.y:z.6f} {pose.theta:z.6f}"

    def _duty(self, words: list[str]) -> str:
        duties = (self._emulator.board.duty(port) for port in range(len(PORTS)))
        return " ".join("coast" if duty is None else f"{duty:z.4f}" for duty in duties)

    def _state(self, words: list[str]) -> str:
        board, plants = self._emulator.board, self._emulator.surroundings.plants
        parts = [f"now {board.now:.3f}", f"supply {board.supply_v:.2f}"]
        parts.append("bootloader" if board.in_bootloader else "firmware")
        for port, name in enumerate(PORTS):
            device, plant = board.devices.get(port), plants.plant(port)
            type_id = "-" if device is None else f"{device.type_id:02X}"
            parts.append(f"{name} {type_id} {plant.angle:z.1f} {plant.speed:z.1f}")
        parts.append(f"lost {self._emulator.loop.lost:.3f}")
        return "; ".join(parts)

    def _help(self, words: list[str]) -> str:
        return " | ".join(
            f"{name} {command.arguments}".rstrip() for name, command in self._commands.items()
        )

    def _motor(self, word: str) -> Turnable:
        motor = self._emulator.surroundings.plants.plant(_port(word))
        assert isinstance(motor, Turnable)  # true of all plants in the emulator
        return motor


def _port(word: str) -> int:
    if word.upper() not in PORTS:
        raise CommandError(f"no port {word!r}; valid are {', '.join(PORTS)}")
    return PORTS.index(word.upper())


def _number(word: str, low: float, high: float) -> float:
    try:
        number = float(word)
    except ValueError:
        number = math.nan
    if not low <= number <= high:
        raise CommandError(f"{word!r} is not valid; valid is a number from {low:g} to {high:g}")
    return number


def _switch(word: str) -> bool:
    if word not in ("on", "off"):
        raise CommandError(f"{word!r} is not valid; valid are on, off")
    return word == "on"
