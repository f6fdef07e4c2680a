"""The filter's answer, which odometry carries on between pictures."""

from __future__ import annotations

from dataclasses import dataclass

from robot.geometry import Pose2
from robot.localization.estimate import Estimate


@dataclass(frozen=True, slots=True)
class Belief:
    """The filter's answer, tied to the odometry that it was made at."""

    estimate: Estimate
    odom_from_robot: Pose2
    """Odometry at the estimate's stamp."""

    def pose(self, odom_from_robot: Pose2) -> Pose2:
        """The estimate carried forward to a later odometry."""
        return self.estimate.pose @ self.moved(odom_from_robot)

    def moved(self, odom_from_robot: Pose2) -> Pose2:
        """The step since then by a later odometry."""
        return self.odom_from_robot.inverse() @ odom_from_robot
