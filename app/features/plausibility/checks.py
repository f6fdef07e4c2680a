"""Checks each scan before the filter has it, and says what cannot be true."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from app.engine.added_models import AddedModels, Clearing
from app.engine.robots import robot_spec
from app.features.plausibility.displacement import Displacement
from app.languages.marking import phrase
from app.settings.config import Config
from robot.fields.field import Field
from robot.geometry import Pose2
from robot.localization.estimate import Alert, Cause, State
from robot.localization.monitoring.monitor import Monitor
from robot.scan import Scan

if TYPE_CHECKING:
    from app.features.plausibility.motion_checks import MotionChecks

STANDS, STANDS_TURN = 0.003, 0.005
"""Of a robot that has moved by less since its last picture, that may be the same [m], [rad]."""
SHOWN = 3.0
"""What was found is said for so long after it was last found [s]."""
FROZEN = Alert(
    Cause.FROZEN,
    phrase(
        "the camera delivers the same picture again and again while the wheels turn: it is not used"
    ),
)
DISPLACED = Alert(
    Cause.WHEEL_SLIP,
    phrase("the robot was not where its wheels had led it: was it pushed, lifted, or stuck?"),
)


@dataclass(slots=True)
class _Memory:
    motion: MotionChecks | None = None
    """None until the robot moves."""
    displacement: Displacement = field(default_factory=Displacement)
    stamp: float = 0.0
    frozen: float = -math.inf
    displaced: float = -math.inf
    """Stamps at which these were last found [s]."""
    picture: int = 0
    """Checksum of the newest picture."""
    pictured: Pose2 | None = None
    """Odometry when that was first seen; None before the first."""


class PlausibilityChecks(AddedModels):
    """Offers no model: it looks at the scans that the program's own ones get."""

    clearing = Clearing.MOTION
    memory: _Memory

    def __init__(self, track: float) -> None:
        """Begin with nothing seen.

        Args:
            track: distance between the wheels [m].
        """
        super().__init__()
        self._track = track
        self.memory = _Memory()

    @property
    def alerts(self) -> tuple[Alert, ...]:
        """What cannot be true; nothing if all can."""
        memory = self.memory
        if memory.stamp < memory.frozen + SHOWN:
            return (FROZEN,)
        by_motion = () if memory.motion is None else memory.motion.alerts(memory.stamp)
        # Where motors are plugged in wrongly, the robot is always elsewhere than they say.
        wrong_plugs = any(alert.cause is Cause.MOTORS for alert in by_motion)
        if memory.stamp < memory.displaced + SHOWN and not wrong_plugs:
            return (DISPLACED,)
        return by_motion

    def advise(self, monitor: Monitor) -> None:
        """Tell what is not known of how late the newest picture is."""
        if self.memory.motion is not None:
            self.memory.motion.advise(monitor)

    def look_at_place(self, state: State, places: Sequence[Pose2], odometry: Pose2) -> None:
        """Look whether the robot was found elsewhere than its wheels led; as ``Displacement``."""
        if self.memory.displacement.was_displaced(state, places, odometry):
            self.memory.displaced = self.memory.stamp

    def forget_place(self) -> None:
        """Forget where the robot was, as somebody has put it elsewhere."""
        self.memory.displacement = Displacement()
        if self.memory.motion is not None:
            self.memory.motion.forget_lateness()

    def cleared(self, scan: Scan, odometry: Pose2) -> Scan:
        """Return a scan as seen from its stamp's place; one of an old picture sees nothing."""
        memory = self.memory
        memory.stamp = scan.stamp
        moved = memory.pictured is not None and _moved(memory.pictured, odometry)
        if scan.picture and scan.picture == memory.picture:
            if not moved:
                return scan
            memory.frozen = scan.stamp
            rays = len(scan.ranges)
            return replace(scan, ranges=np.full(rays, np.inf), sight=np.full((rays, 2), np.nan))
        memory.picture, memory.pictured = scan.picture, odometry
        if memory.motion is None and moved:
            from app.features.plausibility.motion_checks import (  # noqa: PLC0415 - robots stand first
                MotionChecks,
            )

            memory.motion = MotionChecks(self._track)
        if memory.motion is not None:
            memory.motion.add(scan, odometry)
            return memory.motion.on_time(scan)
        return scan


def plausibility_checks(config: Config, floor: Field) -> list[PlausibilityChecks]:
    """Return what checks an engine's scans."""
    return [PlausibilityChecks(robot_spec(config).track)]


def _moved(before: Pose2, after: Pose2) -> bool:
    return before.distance_to(after) > STANDS or abs(before.turn_to(after)) > STANDS_TURN
