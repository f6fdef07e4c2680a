"""Where a replay stands: what the page shows of it."""

from __future__ import annotations

from dataclasses import dataclass

from robot.geometry import Pose2


@dataclass(frozen=True, slots=True)
class ReplayState:
    """At one tick."""

    file: str
    """Name of the recording."""
    position_s: float
    """From its beginning [s]."""
    duration_s: float
    speed: float
    """Seconds of the recording in one second."""
    paused: bool
    catching_up: float | None
    """Share of the way to where somebody wanted to be; None when it is there."""
    estimate_then: Pose2 | None
    """What was estimated then, carried forward to the tick by the wheels."""
