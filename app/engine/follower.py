"""What the engine asks of a filter in each tick; the class itself is a drive without a filter."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from app.engine.own_models.own_models import OwnChoice, OwnModels
from app.engine.steps_by_hand import HandState
from robot.driving.odometry import OdometryState
from robot.geometry import Pose2
from robot.interface import Frame
from robot.localization.estimate import SEARCHING, Belief, Integrity
from robot.localization.filter import Cloud
from robot.localization.parameters import LocalizationParameters
from robot.localization.weighing import Weighing
from robot.scan import Scan
from robot.scanning.line_scanner import LineScan, LineScanner

NO_CLOUD = Cloud(np.empty((0, 3)), np.empty(0))


class Follower:
    """Follows the robot by its measurements; this one ignores them and knows nothing."""

    needs_camera = False
    """Whether a camera that sends no pictures is reported."""
    paused = False
    belief: Belief | None = None
    scanner: LineScanner | None = None
    """Finds tape in pictures; None if it follows none."""
    line_scan: LineScan | None = None
    """What a scanner found in the last picture."""
    parameters = LocalizationParameters()
    own: OwnModels | None = None
    """The user's own models; None if it can use none."""

    @property
    def cloud(self) -> Cloud:
        """The particles with their newest weights."""
        return NO_CLOUD

    @property
    def weighing(self) -> Weighing | None:
        """The scan by which particles are weighed now, and how; None without one."""
        return None

    @property
    def hand(self) -> HandState | None:
        """How far the filter is by hand; None while it works by itself."""
        return None

    @property
    def updates(self) -> int:
        """Measurement updates since the filter last started again."""
        return 0

    @property
    def undoable(self) -> int:
        """How many changes of the belief can be undone."""
        return 0

    @property
    def choice(self) -> OwnChoice:
        """The user's own models in use and on offer."""
        return self.own.choice if self.own else OwnChoice()

    @property
    def fault(self) -> str | None:
        """Why the robot has to stand still: a fault of an own model; None if it may drive."""
        return self.own.fault if self.own else None

    @property
    def trace(self) -> str:
        """The calls that led to the fault in a user's file; empty if there is none."""
        return self.own.trace if self.own else ""

    @property
    def complaints(self) -> Mapping[str, str | None]:
        """What is wrong, by topic; None if nothing is."""
        return self.own.problems if self.own else {}

    def integrity_at(self, odom_from_robot: Pose2) -> Integrity:
        """Return the integrity of the estimate, carried forward to a later odometry pose."""
        return SEARCHING

    def is_saved(self, stamp: float) -> bool:
        """Return whether the user saved a model in use since the last call, at a stamp [s]."""
        return self.own is not None and self.own.saved(stamp)

    def note(self, odom_from_robot: Pose2) -> None:
        """Note the present odometry pose, before commands that may set the filter's pose."""

    def measure(self, seen: Frame | Scan, odometry: OdometryState) -> None:
        """Take a picture or a laser's scan, with the odometry at its stamp."""
