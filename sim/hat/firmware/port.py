"""One port of the board, with all of its state in the firmware, and its link to a device."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from struct import Struct

from sim.hat.firmware.drive import Controller, HBridge, Waveform
from sim.hat.firmware.reports import Selection, Writer, combination_line, mode_line
from sim.hat.firmware.variables import MODES, ModeData, Modes
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


Pairs = tuple[tuple[int, int], ...]


class Port:
    """Drive, selection and received data of a port, 0 to 3."""

    def __init__(self, number: int, write: Writer) -> None:
        self.number = number
        self._write = write
        self.bridge = HBridge()
        self.selection = Selection()
        self.known: LegoMotor | None = None
        """The device that was set up last; its type and modes stay known after it is lost."""
        self.link: DeviceLink | None = None
        """The open connection to an active device."""
        self.connected = False
        self.data = [ModeData() for _ in range(MODES)]
        self.combinations: dict[int, Pairs] = {}
        """Mode and data set of each pair, by slot."""
        self.reset_drive()

    def reset_drive(self) -> None:
        """Reset settings and setpoint to those without a device."""
        self.wave = Waveform()
        self.controller = Controller()
        self.bridge.reset()
        self.coasting = False

    def forget_device(self) -> None:
        """Forget the device, and all data that were received."""
        self.known = None
        self.connected = False
        self.combinations.clear()
        for data in self.data:
            data.length = 0
            data.content[:] = bytes(len(data.content))

    def describe(self) -> str:
        """Return its part of ``list``."""
        if self.known is None or not self.connected:
            return f"P{self.number}: no device detected\r\n"
        return self.known.description(self.number)

    def run_drive(self, modes: Modes) -> None:
        """Update setpoint, controller and bridge; called every 10 ms."""
        ended = self.wave.advance()
        if ended is not None:
            self._write(f"P{self.number}: {ended.value} done\r\n")
        if not self.connected:
            self.bridge.drive(0.0)
        elif self.coasting:
            self.bridge.coast()
        else:
            wanted = self.controller.drive(modes, self.wave.setpoint)
            if wanted is not None:
                self.bridge.drive(wanted)

    def receive(self, payload: bytes, mode: int, current: int) -> None:
        """Take a data message of the device, in a mode, at a time [ms]."""
        self.data[mode].store(payload)
        if mode == self.selection.mode:
            self.selection.arrived(current)

    def report(self) -> None:
        """Write a report of the selected data."""
        number, mode = self.number, self.selection.mode
        assert mode is not None
        pairs = self.combinations.get(mode)
        if pairs is not None:
            known = () if self.known is None else self.known.modes
            line = combination_line(number, mode, pairs, known, self.data[mode])
        elif self.known is not None and mode < len(self.known.modes):
            line = mode_line(number, mode, self.known.modes[mode], self.data[mode])
        else:
            line = ""
        self._write(line)

    def select(self, mode: int, period: int) -> None:
        """Report a mode; send the device its new mode if it changes."""
        chosen = self.selection
        chosen.period = period
        if chosen.mode != mode:
            self.send(EXTENDED, bytes([mode & 8]))
            self.send(SELECT, bytes([mode & 7]))
            chosen.mode = mode
        chosen.fresh = False

    def combine(self, slot: int, pairs: Sequence[tuple[int, int]]) -> None:
        """Send the device the combination of a slot; empty ``pairs`` remove it."""
        head = bytes([0x20 + len(pairs), slot])
        self.send(COMBINE, head + bytes((mode << 4) + part for mode, part in pairs))

    def send(self, kind: int, payload: bytes) -> None:
        """Send a message to the device; without a connection it is lost."""
        if self.link is not None:
            self.link.hear(kind, payload)
