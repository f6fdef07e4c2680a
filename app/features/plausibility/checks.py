"""Checks each scan before the filter has it, and says what cannot be true."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from app.engine.added_models import AddedModels
from app.engine.robots import robot_spec
from app.languages.marking import phrase
from app.settings.config import Config
from robot.fields.field import Field
from robot.geometry import Pose2
from robot.localization.estimate import Alert, Cause
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


class PlausibilityChecks(AddedModels):
    """Offers no model: it looks at the scans that the program's own ones get."""

    def __init__(self, track: float) -> None:
        """Begin with nothing seen.

        Args:
            track: distance between the wheels [m].
        """
        super().__init__()
        self._track = track
        self._motion: MotionChecks | None = None
        """None until the robot moves."""
        self._stamp = 0.0
        self._frozen = self._displaced = -math.inf
        """Stamps at which these were last found [s]."""
        self._pictured: Pose2 | None = None
        """Odometry when the newest picture was first seen; None before the first."""

    @property
    def alerts(self) -> tuple[Alert, ...]:
        """What cannot be true; nothing if all can."""
        if self._is_shown(self._frozen):
            return (FROZEN,)
        if self._is_shown(self._displaced):
            return (DISPLACED,)
        return () if self._motion is None else self._motion.alerts(self._stamp)

    def _is_shown(self, stamp: float) -> bool:
        return 0 <= self._stamp - stamp < SHOWN  # a replay may be at an earlier time again

    def note_displaced(self) -> None:
        """Note that the robot was found again, elsewhere than its wheels had led."""
        self._displaced = self._stamp

    def cleared(self, scan: Scan, odometry: Pose2) -> Scan:
        """Return a scan as it is, or one that sees nothing if its picture is an old one."""
        self._stamp = scan.stamp
        moved = self._pictured is not None and _moved(self._pictured, odometry)
        if scan.repeated:
            if not moved:
                return scan
            self._frozen = scan.stamp
            rays = len(scan.ranges)
            return replace(scan, ranges=np.full(rays, np.inf), sight=np.full((rays, 2), np.nan))
        self._pictured = odometry
        if self._motion is None and moved:
            from app.features.plausibility.motion_checks import (  # noqa: PLC0415 - robots stand first
                MotionChecks,
            )

            self._motion = MotionChecks(self._track)
        if self._motion is not None:
            self._motion.add(scan, odometry)
        return scan


def plausibility_checks(config: Config, field: Field) -> list[PlausibilityChecks]:
    """Return what checks an engine's scans."""
    return [PlausibilityChecks(robot_spec(config).track)]


def _moved(before: Pose2, after: Pose2) -> bool:
    return before.distance_to(after) > STANDS or abs(before.turn_to(after)) > STANDS_TURN
