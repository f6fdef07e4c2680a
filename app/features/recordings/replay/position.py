"""How far a recording was read: everything that its next ticks depend on."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import TypeVar

import numpy as np

from app.features.recordings.replay.decoding import ContentError, health_of, volts_of
from app.features.recordings.replay.ticks import RecordedTick, RecordedTopics
from app.features.ros.message_types import MessageError
from robot.geometry import Array, Pose2

SHOWN_NS = 2_000_000_000
"""How long a problem of the recording itself is shown [ns]."""

TRUE_NS = 250_000_000
"""How long the wheels carry the last recorded truth forward [ns]."""

LEAP = 10.0
"""If a wheel turned farther [rad] while the stamps jumped back, its count began again."""

USUAL_NS, LONGEST_NS = 20_000_000, 1_000_000_000
"""Shortest and longest duration that is assumed for a tick if the stamps jump back [ns]."""


T = TypeVar("T")


@dataclass(frozen=True, slots=True, eq=False)
class NextTick:
    """The tick that comes next, with its joints."""

    tick: RecordedTick
    stamp_ns: int
    positions: Array
    velocities: Array | None
    trouble: str


BAD = (MessageError, ContentError, ValueError, TypeError, AttributeError)
"""Exceptions from decoding a message that does not fit its type."""


class TickMessages:
    """The messages of a tick; one that cannot be read counts as missing, and is reported."""

    def __init__(self, next_tick: NextTick) -> None:
        self.tick = next_tick.tick
        self.trouble = next_tick.trouble

    def of(self, topic: str, read: Callable[[bytes], T]) -> T | None:
        """Decode the newest message of a topic; None if there is none that can be read."""
        cdr = self.tick.newest.get(topic)
        return None if cdr is None else self.read(read, cdr)

    def read(self, read: Callable[[bytes], T], cdr: bytes) -> T | None:
        """Decode a message; None if it cannot be read."""
        try:
            return read(cdr)
        except BAD as error:
            self.trouble = str(error)
            return None


@dataclass(frozen=True, eq=False)
class ReadPosition:
    """How far a recording was read, and what its next ticks depend on."""

    log_ns: int = -1
    """Time of the last tick [ns since 1970]; before the first it is negative."""
    now_ns: int = 0
    """The robot's clock at that tick [ns]; it begins with the recording and never jumps back."""
    shift_ns: int = 0
    """Offset from recorded stamps to the robot's clock [ns]."""
    counted: Array | None = None
    """Joint positions (j,) [rad] as recorded."""
    ahead: Array = field(default_factory=lambda: np.zeros(1))
    """How far the robot's joint positions are ahead of the recorded ones (j,) [rad]: recorded
    counts may begin again, the robot's do not."""
    picture_log_ns: int = -1
    """Time of the tick that handed out the last picture."""
    truth: Pose2 | None = None
    truth_ns: int = 0
    """The robot's clock when the truth was last recorded [ns]."""
    battery_v: float | None = None
    connected: bool = True
    faults: tuple[str, ...] = ()
    trouble: str = ""
    """What is wrong with the recording."""
    trouble_ns: int = 0
    """Log time of that problem [ns since 1970]."""

    def after(self, next_tick: NextTick) -> ReadPosition:
        """Return the position after a tick, with its clock and joint positions."""
        last, log_ns = self, next_tick.tick.log_ns
        if last.counted is None:
            nought = np.zeros(len(next_tick.positions))
            return replace(
                last,
                log_ns=log_ns,
                shift_ns=-next_tick.stamp_ns,
                counted=next_tick.positions,
                ahead=nought,
            )
        place = replace(last, log_ns=log_ns, counted=next_tick.positions)
        now_ns = next_tick.stamp_ns + last.shift_ns
        if now_ns > last.now_ns:
            return replace(place, now_ns=now_ns)
        lasted = min(max(log_ns - last.log_ns, USUAL_NS), LONGEST_NS)
        back, leap = last.now_ns - now_ns, last.counted - next_tick.positions
        counted_anew = np.abs(leap).max() > LEAP
        return replace(
            place,
            now_ns=last.now_ns + lasted,
            shift_ns=last.now_ns + lasted - next_tick.stamp_ns,
            ahead=last.ahead + leap if counted_anew else last.ahead,
            trouble=f"In the recording, the stamps jump back by {back / 1e9:.3g} s; "
            "what follows is taken as what came next.",
            trouble_ns=log_ns,
        )

    def turned(self, next_tick: NextTick, after: ReadPosition) -> Array:
        """How far the joints turned (j,) [rad] from this position to the one after a tick."""
        if self.counted is None or after.counted is None:
            return np.zeros(len(next_tick.positions))
        turned: Array = after.counted + after.ahead - self.counted - self.ahead
        return turned

    def moved(self, moved: Pose2) -> ReadPosition:
        """Carry the truth forward by the wheels, because it is recorded at a lower rate."""
        known = self.truth is not None and self.now_ns - self.truth_ns < TRUE_NS
        return replace(self, truth=self.truth @ moved if known and self.truth else None)

    def with_status(self, given: TickMessages, topics: RecordedTopics) -> ReadPosition:
        """Take the values that are recorded now and then; each is valid until the next message."""
        place = self
        volts = given.of(topics.battery_state, volts_of)
        if volts is not None:
            place = replace(place, battery_v=volts)
        health = given.of(topics.diagnostics, health_of)
        if health is not None:
            place = replace(place, connected=health[0], faults=health[1])
        return place

    def troubled(self, trouble: str) -> ReadPosition:
        """Add a problem of the recording at this position."""
        return replace(self, trouble=trouble, trouble_ns=self.log_ns)

    @property
    def troubles(self) -> tuple[str, ...]:
        """What is wrong with the recording; shown for a while."""
        shown = self.trouble and self.log_ns - self.trouble_ns < SHOWN_NS
        return (self.trouble,) if shown else ()
