"""What ticks show of motion in pictures."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from app.engine.snapshot import Snapshot
from app.engine.value import Shown, Value
from robot.picture_odometry.settings import NAME

if TYPE_CHECKING:
    from app.features.picture_odometry.companion import PictureOdometryState


def motion_state(snapshot: Snapshot) -> PictureOdometryState | None:
    """Return what it shows of itself in a tick; None if motion is not measured."""
    state: PictureOdometryState | None = snapshot.added.get(NAME)
    return state


def _wheels(snapshot: Snapshot) -> Shown:
    state = motion_state(snapshot)
    return None if state is None else state.wheels.value


def _seen(snapshot: Snapshot) -> Shown:
    state = motion_state(snapshot)
    return None if state is None else state.motion.seen


def _speed(snapshot: Snapshot) -> Shown:
    """Speed over the floor as pictures show it; None where it is not seen."""
    state = motion_state(snapshot)
    if state is None or state.motion.seen < 3:
        return None
    moved = state.motion
    return 1000 * math.hypot(moved.motion.x, moved.motion.y) / (moved.end - moved.begin)


VALUES = (
    Value("wheels", _wheels),
    Value("floor_seen", _seen),
    Value("floor_speed_mm_s", _speed, ".0f"),
)
