"""A follower: what the engine asks of a filter in each tick; the class itself has no filter."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from app.engine.added_models import AddedModels, ModelChoice
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


@dataclass(frozen=True, slots=True)
class FilterState:
    """What scanner and filter show of themselves at a tick; by default nothing follows the robot.

    A new value is a line here, and one where its follower makes it; ``Snapshot.filter`` has it.
    """

    scanner: LineScanner | None = field(default=None, repr=False)
    """What finds tape in pictures now; None if nothing does."""
    line_scan: LineScan | None = field(default=None, repr=False)
    """What the scanner found in the last picture that was used."""
    cloud: Cloud = field(default=NO_CLOUD, repr=False)
    """The particles with their newest weights; by hand, as they stand."""
    weighing: Weighing | None = field(default=None, repr=False)
    """The scan by which particles are weighed now, and how; None before the first."""
    hand: HandState | None = field(default=None, repr=False)
    """How far the filter is by hand; None while it works by itself."""
    paused: bool = False
    updates: int = 0
    """Measurement updates since the filter last started again."""
    undoable: int = 0
    """How many changes of the belief can be undone."""
    parameters: LocalizationParameters = field(default=LocalizationParameters(), repr=False)
    models: ModelChoice = field(default=ModelChoice(), repr=False)
    """Models of features, in use and on offer."""
    fault: str | None = None
    """What is wrong with these models, with file and line; the robot stands still meanwhile."""
    trace: str = field(default="", repr=False)
    """The calls that led to that fault, from the model's file on."""


class Follower:
    """Follows the robot by its measurements; this one ignores them and knows nothing."""

    needs_camera = False
    """Whether a camera that sends no pictures is reported."""
    belief: Belief | None = None
    added: tuple[AddedModels, ...] = ()
    """Models of features, as far as it can use any."""

    @property
    def shown(self) -> FilterState:
        """What it shows of itself now."""
        return FilterState()

    @property
    def settled(self) -> bool:
        """Whether more pictures tell it nothing new while the robot stands."""
        return True

    @property
    def fault(self) -> str | None:
        """Why the robot has to stand still: a fault of a feature's model; None if it may drive."""
        return next((models.fault for models in self.added if models.fault), None)

    @property
    def complaints(self) -> Mapping[str, str | None]:
        """What is wrong, by topic; None if nothing is."""
        return {topic: words for each in self.added for topic, words in each.problems.items()}

    def integrity_at(self, odom_from_robot: Pose2) -> Integrity:
        """Return the integrity of the estimate, carried forward to a later odometry pose."""
        return SEARCHING

    def note(self, odom_from_robot: Pose2) -> None:
        """Note the present odometry pose, before commands that may set the filter's pose."""

    def measure(self, seen: Frame | Scan, odometry: OdometryState) -> None:
        """Take a picture or a laser's scan, with the odometry at its stamp."""
