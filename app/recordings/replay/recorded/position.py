"""How far a recording was read: all that its next ticks depend on."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Protocol, TypeVar

import numpy as np

from app.recordings.replay.recorded.decoding import health_of, volts_of
from app.recordings.replay.recorded.ticks import RecordedTick
from app.recordings.replay.recorded.topics import RecordedTopics
from robot.geometry import Array, Pose2

SHOWN_NS = 2_000_000_000
"""So long a trouble of the recording itself is shown."""

TRUE_NS = 250_000_000
"""So long the wheels carry the truth on from where it was told."""

LEAP = 10.0
"""A wheel that turned farther [rad] while the stamps jumped back was counted anew from there."""

USUAL_NS, LONGEST_NS = 20_000_000, 1_000_000_000
"""The time that a tick is taken to last where its stamp cannot tell, and at most."""


T = TypeVar("T")


class TickMessages(Protocol):
    """What came with a tick."""

    def of(self, topic: str, read: Callable[[bytes], T]) -> T | None:
        """What the newest message of a topic tells; None if there is none that can be read."""
        ...


@dataclass(frozen=True, slots=True)
class NextTick:
    """The tick that comes next, with its joints."""

    tick: RecordedTick
    stamp_ns: int
    positions: Array
    velocities: Array | None
    trouble: str


@dataclass(frozen=True)
class ReadPosition:
    """How far a recording was read, and what its next ticks depend on."""

    log_ns: int = -1
    """Time of the last tick [ns since 1970]; before the first it is negative."""
    now_ns: int = 0
    """The robot's clock then: it begins with the recording, and never jumps back."""
    shift_ns: int = 0
    """From recorded stamps to the robot's clock."""
    counted: Array | None = None
    """Joint positions (j,) [rad] as recorded."""
    ahead: Array = field(default_factory=lambda: np.zeros(1))
    """How far the robot's are ahead of them: after they were counted anew."""
    picture_log_ns: int = -1
    """Time of the tick that handed out the last picture."""
    truth: Pose2 | None = None
    truth_ns: int = 0
    """The robot's clock when it was told."""
    battery_v: float | None = None
    connected: bool = True
    faults: tuple[str, ...] = ()
    trouble: str = ""
    """What is wrong with the recording."""
    trouble_ns: int = 0
    """When that was."""

    def after(self, next_tick: NextTick) -> ReadPosition:
        """The place after a tick, with its clock."""
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
        """How far the joints turned (j,) [rad] to a tick, and the place after it."""
        if self.counted is None or after.counted is None:
            return np.zeros(len(next_tick.positions))
        turned: Array = after.counted + after.ahead - self.counted - self.ahead
        return turned

    def moved(self, moved: Pose2) -> ReadPosition:
        """The truth carried on by the wheels: it is recorded at a lower rate."""
        known = self.truth is not None and self.now_ns - self.truth_ns < TRUE_NS
        return replace(self, truth=self.truth @ moved if known and self.truth else None)

    def told(self, given: TickMessages, topics: RecordedTopics) -> ReadPosition:
        """With what is told now and then: it holds until it is told anew."""
        place = self
        volts = given.of(topics.battery_state, volts_of)
        if volts is not None:
            place = replace(place, battery_v=volts)
        health = given.of(topics.diagnostics, health_of)
        if health is not None:
            place = replace(place, connected=health[0], faults=health[1])
        return place

    def troubled(self, trouble: str) -> ReadPosition:
        """With something that is wrong with the recording here."""
        return replace(self, trouble=trouble, trouble_ns=self.log_ns)

    @property
    def troubles(self) -> tuple[str, ...]:
        """What is wrong with the recording, for a while."""
        shown = self.trouble and self.log_ns - self.trouble_ns < SHOWN_NS
        return (self.trouble,) if shown else ()
