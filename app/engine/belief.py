"""The filter's estimate, which odometry carries forward between pictures."""

from __future__ import annotations

from dataclasses import dataclass

from robot.geometry import Pose2
from robot.localization.estimate import Estimate


@dataclass(frozen=True, slots=True)
class Belief:
    """The filter's estimate, with the odometry at its stamp."""

    estimate: Estimate
    odom_from_robot: Pose2
    """Odometry at the estimate's stamp."""

    def pose(self, odom_from_robot: Pose2) -> Pose2:
        """Return the estimated pose, carried forward to a later odometry pose."""
        return self.estimate.pose @ self.moved(odom_from_robot)

    def moved(self, odom_from_robot: Pose2) -> Pose2:
        """Return the robot's motion from the estimate's stamp to a later odometry pose."""
        return self.odom_from_robot.inverse() @ odom_from_robot
