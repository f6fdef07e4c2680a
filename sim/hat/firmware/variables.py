"""Numbers taken out of the data that devices have sent: what a controller or a setpoint watches."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from struct import Struct

from sim.hat.firmware.single import single

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
"""Differences are taken once in 10 ms, and are told as a rate [1/s]."""


@dataclass(slots=True)
class ModeData:
    """What has been received in one mode; a shorter message leaves the rest of a longer one."""

    content: bytearray = field(default_factory=lambda: bytearray(PAYLOAD + 4))
    length: int = 0
    """Of the newest message [bytes]; 0: there was none."""

    def store(self, payload: bytes) -> None:
        """Keep a message."""
        self.content[: len(payload)] = payload
        self.length = len(payload)


Modes = Sequence[Sequence[ModeData]]
"""What all ports have received: by port, then by mode."""


@dataclass(slots=True)
class Variable:
    """A scaled variable: a number at a place in a mode's data, perhaps on a circle."""

    port: int = 0
    mode: int = 0
    offset: int = 0
    format: str = ""
    scale: float = 0.0
    unwrap: float = 0.0
    """Size of the circle after scaling; 0: a line."""
    _last: float | None = None

    def read(self, modes: Modes, rate: bool, value: float) -> float | None:
        """What to make of the newest data, or None if there is none yet.

        On a circle the way since the last reading is added to ``value``, the result of last time.
        ``rate`` asks for the difference to the last reading, per second.
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
