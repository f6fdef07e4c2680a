"""Reports of a device's data: when they are due, and their text."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from struct import Struct

from sim.hat.firmware.variables import ModeData
from sim.hat.lego_motor import Mode, ValueType

OFF, EACH_MESSAGE = -1, 0
"""Special values of a period, which are not times."""

DEFAULT_PERIOD = 100
"""Period after every ``select`` [ms]."""

INTEGERS = {
    ValueType.INT8: Struct("<b"),
    ValueType.INT16: Struct("<h"),
    ValueType.INT32: Struct("<i"),
}


Writer = Callable[[str], None]
"""Queues text for the host; what does not fit into the queue is lost."""


@dataclass(slots=True)
class Selection:
    """The data that a port reports."""

    mode: int | None = None
    """Selected mode or combination."""
    period: int = OFF
    """Time between reports [ms], or ``OFF`` or ``EACH_MESSAGE``."""
    fresh: bool = False
    """Whether a message came since the selection, or, for ``EACH_MESSAGE``, the last report."""
    since: int = 0
    """Time at which the period until the next report began [ms]."""

    def clear(self) -> None:
        """Select nothing and report nothing."""
        self.mode = None
        self.period = OFF
        self.fresh = False

    def forget_mode(self) -> None:
        """Report nothing until the next ``select``, which sends the mode to the device again."""
        self.mode = None

    def arrived(self, current: int) -> None:
        """Take note of a message in the selected mode [ms]; the first one starts the period."""
        if not self.fresh:
            self.fresh = True
            self.since = current

    def is_due(self, current: int, has_room: Callable[[], bool]) -> bool:
        """Return whether to report at a time [ms]; if so, this counts as the report.

        Args:
            current: the time [ms].
            has_room: whether the transmit ring is less than half full; otherwise reports wait.
        """
        if not self.fresh or self.mode is None or self.period == OFF:
            return False
        if current - self.since < self.period or not has_room():
            return False
        if self.period == EACH_MESSAGE:
            self.fresh = False
        self.since = current
        return True


Pairs = Sequence[tuple[int, int]]
"""Mode and data set of each value of a combination."""


def mode_line(port: int, number: int, mode: Mode, data: ModeData) -> str:
    """Return a line with all received numbers of a mode; empty if there are none."""
    if data.length == 0:
        return ""
    size = mode.type.size
    offsets = range(0, min(mode.count * size, data.length - size + 1), size)
    values = "".join(" " + _text(mode.type, data, offset) for offset in offsets)
    return f"P{port}M{number}:{values}\r\n"


def combination_line(
    port: int, slot: int, pairs: Pairs, modes: Sequence[Mode], data: ModeData
) -> str:
    """Return a line with one number for each pair of a combination, in their order."""
    line, offset = f"P{port}C{slot}:", 0
    for number, _ in pairs:
        kind = modes[number].type if number < len(modes) else ValueType.INT8
        line += " " + _text(kind, data, offset)
        offset += kind.size
    return line + "\r\n"


def _text(kind: ValueType, data: ModeData, offset: int) -> str:
    (value,) = INTEGERS[kind].unpack_from(data.content, offset)
    return f"{value:+d}" if value else " 0"
