"""The state of a replay, as the page shows it."""

from __future__ import annotations

from dataclasses import dataclass

from robot.geometry import Pose2


@dataclass(frozen=True, slots=True)
class ReplayState:
    """State of a replay at one tick."""

    file: str
    """Name of the recording."""
    position_s: float
    """Time since the recording's beginning [s]."""
    duration_s: float
    speed: float
    """Seconds of the recording in one second."""
    paused: bool
    catching_up: float | None
    """Share of the way to the requested time, 0 to 1; None when the replay is there."""
    estimate_then: Pose2 | None
    """The recorded estimate, carried forward to the tick by odometry."""
