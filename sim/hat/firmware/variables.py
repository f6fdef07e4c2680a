"""Numbers in single precision, and variables: numbers in the devices' data that are watched."""

from __future__ import annotations

from collections.abc import Sequence
from ctypes import c_float
from dataclasses import dataclass, field
from struct import Struct

MODES = 16
PAYLOAD = 128
"""Longest data message [bytes]."""
LAYOUTS = {
    "u1": Struct("<B"),
    "s1": Struct("<b"),
    "u2": Struct("<H"),
    "s2": Struct("<h"),
    "u4": Struct("<I"),
    "s4": Struct("<i"),
    "f4": Struct("<f"),
}
RATE = 100.0
"""Number of differences a second, one each 10 ms: it converts them to a rate [1/s]."""


def single(value: float) -> float:
    """Return the nearest IEEE 754 single, or an infinity beyond its range."""
    return c_float(value).value


def clamped(value: float, low: float, high: float) -> float:
    """Clip ``value`` to ``low`` first and then to ``high``, as the firmware does."""
    value = max(value, low)
    return min(value, high)


@dataclass(slots=True)
class ModeData:
    """Data received in one mode; a shorter message leaves the rest of a longer one unchanged."""

    content: bytearray = field(default_factory=lambda: bytearray(PAYLOAD + 4))
    length: int = 0
    """Length of the newest message [bytes]; 0: there was none."""

    def store(self, payload: bytes) -> None:
        """Store a message."""
        self.content[: len(payload)] = payload
        self.length = len(payload)


Modes = Sequence[Sequence[ModeData]]
"""Received data of all ports: by port, then by mode."""


@dataclass(slots=True)
class Variable:
    """Scaled variable: a number at an offset in a mode's data, which may wrap on a circle."""

    port: int = 0
    mode: int = 0
    offset: int = 0
    format: str = ""
    scale: float = 0.0
    unwrap: float = 0.0
    """Size of the circle after scaling; 0: the number does not wrap."""
    _last: float | None = None

    def read(self, modes: Modes, rate: bool, value: float) -> float | None:
        """Return the value or rate of the newest data; None if there are no data yet.

        Args:
            modes: data of all ports.
            rate: True: return the difference from the last reading, per second.
            value: the last result; on a circle, the step since the last reading is added to it.
        """
        data = modes[self.port][self.mode]
        if data.length == 0:
            return None
        number = self._number(data)
        if self._last is None:
            self._last = value = number
        step = single(number - self._last)
        self._last = number
        if self.unwrap != 0:
            step = self._shorter_way(step)
        if rate:
            return single(step * RATE)
        return number if self.unwrap == 0 else single(value + step)

    def _number(self, data: ModeData) -> float:
        layout = LAYOUTS.get(self.format)
        if layout is None:
            return 0.0
        (number,) = layout.unpack_from(data.content, self.offset)
        return single(single(number) * self.scale)

    def _shorter_way(self, step: float) -> float:
        half = single(self.unwrap / 2)
        if step > half:
            step = single(step - self.unwrap)
        if step < -half:
            step = single(step + self.unwrap)
        return step
