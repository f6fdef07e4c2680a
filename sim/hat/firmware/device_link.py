"""The device's side of its link to a port: the mode that it sends, and its messages."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from struct import Struct

from sim.hat.lego_motor import LegoMotor, ValueType

SELECT, COMBINE, EXTENDED = 0x43, 0x44, 0x46
"""Types of messages to a device; the bits outside ``TYPE_BITS`` give the length."""

TYPE_BITS = 0xC7
COMBINATION = 0x20
"""Upper half of the first byte of a combination; the lower half is the number of its pairs."""

LETTERS = {
    ValueType.INT8: "b",
    ValueType.INT16: "h",
    ValueType.INT32: "i",
}


@dataclass(slots=True)
class DeviceLink:
    """Link to one plugged-in device, which starts in mode 0."""

    device: LegoMotor
    mode: int = 0
    _upper: int = 0
    """8 if the next selected mode is 8 or higher, else 0."""
    _pairs: dict[int, tuple[tuple[int, int], ...]] = field(default_factory=dict)
    """Mode and data set of each value that a combination sends, by its number."""
    _layout: Struct | None = None

    def hear(self, kind: int, payload: bytes) -> None:
        """Take a message from the board; the device ignores messages that it does not know."""
        kind &= TYPE_BITS
        if kind == SELECT and payload:
            self.mode = self._upper | payload[0] & 7
            self._layout = None
        elif kind == EXTENDED and payload:
            self._upper = payload[0] & 8
        elif kind == COMBINE and len(payload) > 1 and payload[0] & 0xF0 == COMBINATION:
            count = payload[0] & 0x0F
            self._combine(payload[1] & 0x0F, payload[2 : 2 + count])

    def message(self) -> bytes:
        """Return the newest data of the selected mode, padded to a power of two [bytes].

        It is empty if the device does not have the mode.
        """
        pairs = self._pairs.get(self.mode)
        if pairs is None:
            if self.mode >= len(self.device.modes):
                return b""
            values = self.device.read(self.mode)
        else:
            values = tuple([self.device.read(mode)[part] for mode, part in pairs])
        layout = self._layout or self._make_layout(pairs)
        return layout.pack(*values)

    def _combine(self, slot: int, pairs: bytes) -> None:
        self._layout = None
        self._pairs.pop(slot, None)
        wanted = tuple((pair >> 4, pair & 0x0F) for pair in pairs)
        if wanted and self._may_combine(wanted):
            self._pairs[slot] = wanted

    def _may_combine(self, pairs: Sequence[tuple[int, int]]) -> bool:
        modes = self.device.modes
        allowed = any(
            all(mode in together for mode, _ in pairs) for together in self.device.combinations
        )
        return allowed and all(part < modes[mode].count for mode, part in pairs)

    def _make_layout(self, pairs: tuple[tuple[int, int], ...] | None) -> Struct:
        modes = self.device.modes
        if pairs is None:
            letters = LETTERS[modes[self.mode].type] * modes[self.mode].count
        else:
            letters = "".join(LETTERS[modes[mode].type] for mode, _ in pairs)
        size = Struct("<" + letters).size
        padded = 1 << (size - 1).bit_length()
        self._layout = Struct(f"<{letters}{padded - size}x")
        return self._layout
