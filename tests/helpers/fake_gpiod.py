"""The kernel's GPIO library, version 2, over chips that are none: its names, rules and errors."""

from __future__ import annotations

import enum
import errno
import os
from dataclasses import dataclass, field
from types import SimpleNamespace

PI_4 = ["ID_SDA", "ID_SCL", *(f"GPIO{number}" for number in range(2, 28)), *["-"] * 30]
PI_4_MAINLINE = ["ID_SDA", "ID_SCL", "SDA1", "SCL1", "GPIO_GCLK", *PI_4[5:]]
PI_5_POWER = [f"GPIO_{number:03}" for number in range(32)]
EXPANDER = ["BT_ON", "WL_ON", "PWR_LED_OFF", "", "VDD_SD_IO_SEL", "CAM_GPIO", "SD_PWR_ON", ""]


class Direction(enum.Enum):
    AS_IS, INPUT, OUTPUT = 1, 2, 3


class Value(enum.Enum):
    INACTIVE, ACTIVE = 0, 1


@dataclass
class LineSettings:
    direction: Direction = Direction.AS_IS
    output_value: Value = Value.INACTIVE


@dataclass
class LineInfo:
    offset: int
    name: str
    used: bool
    consumer: str
    direction: Direction


@dataclass
class Line:
    """One pin as the kernel keeps it."""

    name: str
    consumer: str | None = None
    direction: Direction = Direction.INPUT
    value: int = 1
    """Both are pulled up on the board."""


@dataclass
class Pins:
    """Chips by their paths; ``forbidden`` are those that this user may not open."""

    chips: dict[str, list[Line]] = field(default_factory=dict)
    forbidden: set[str] = field(default_factory=set)
    opened: int = 0
    """Chips and requests that nobody has closed yet."""

    def add(self, path: object, names: list[str]) -> list[Line]:
        """Plug a chip in."""
        self.chips[str(path)] = [Line(name) for name in names]
        return self.chips[str(path)]

    def line(self, name: str) -> Line:
        (found,) = [line for lines in self.chips.values() for line in lines if line.name == name]
        return found

    def module(self) -> SimpleNamespace:
        """What ``import gpiod`` gives."""
        line = SimpleNamespace(Direction=Direction, Value=Value)
        return SimpleNamespace(
            Chip=lambda path: Chip(self, path), LineSettings=LineSettings, line=line
        )


class _Closing:
    """What is closed at the end of a ``with``."""

    def __init__(self, pins: Pins) -> None:
        self.pins = pins
        pins.opened += 1

    def __enter__(self):
        return self

    def __exit__(self, *_error: object) -> None:
        self.pins.opened -= 1


class Chip(_Closing):
    def __init__(self, pins: Pins, path: str) -> None:
        if path in pins.forbidden:
            raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))
        if path not in pins.chips:
            raise OSError(errno.ENOTTY, os.strerror(errno.ENOTTY))
        super().__init__(pins)
        self.lines = pins.chips[path]

    def line_offset_from_id(self, id: str | int) -> int:
        if isinstance(id, int):
            return id
        for offset, line in enumerate(self.lines):
            if line.name == id:
                return offset
        raise FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT))

    def get_line_info(self, line: str | int) -> LineInfo:
        offset = self.line_offset_from_id(line)
        one = self.lines[offset]
        used = one.consumer is not None
        return LineInfo(offset, one.name, used, one.consumer or "", one.direction)

    def request_lines(self, config: dict, consumer: str | None = None) -> LineRequest:
        lines = {name: self.lines[self.line_offset_from_id(name)] for name in config}
        if any(line.consumer is not None for line in lines.values()):
            raise OSError(errno.EBUSY, os.strerror(errno.EBUSY))
        request = LineRequest(self.pins, lines)
        for line in lines.values():
            line.consumer = consumer or "?"
        request.reconfigure_lines(config)
        return request


class LineRequest(_Closing):
    def __init__(self, pins: Pins, lines: dict[str, Line]) -> None:
        super().__init__(pins)
        self.lines = lines

    def __exit__(self, *error: object) -> None:
        super().__exit__(*error)
        for line in self.lines.values():
            line.consumer = None  # and it stays as it was driven

    def set_value(self, line: str, value: Value) -> None:
        one = self.lines[line]
        if one.direction is not Direction.OUTPUT:
            raise PermissionError(errno.EPERM, os.strerror(errno.EPERM))
        one.value = value.value

    def reconfigure_lines(self, config: dict) -> None:
        for name, settings in config.items():
            line = self.lines[name]
            line.direction = settings.direction
            line.value = settings.output_value.value if line.direction is Direction.OUTPUT else 1
