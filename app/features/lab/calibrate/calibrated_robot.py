"""A robot that was measured by a drive."""

from __future__ import annotations

from dataclasses import dataclass, field
from datetime import UTC, datetime

from robot.calibration.calibrate import Calibration
from robot.description.lens_table import MeasuredLens
from robot.description.profile import Profile
from robot.description.spec import RobotSpec
from robot.description.unknowns import ROBOT
from robot.fields.field import Field
from robot.geometry import Array


@dataclass(frozen=True, eq=False)
class CalibratedRobot:
    """A drive that was adjusted."""

    spec: RobotSpec
    calibration: Calibration
    taped: Field
    stamps: Array = field(repr=False)
    """(k,) of the pictures [s]."""
    source: str
    """What it was measured from."""
    lens: MeasuredLens | None = None
    """The lens that it was measured through, if it is another than the described one."""

    @property
    def profile(self) -> Profile:
        """The profile to be written."""
        values, sd = self.calibration.values[:ROBOT], self.calibration.sd[:ROBOT]
        made, fit = datetime.now(UTC), self.calibration.quality.table()
        return Profile(self.spec.name, made, self.source, values, sd, self.lens, fit)
