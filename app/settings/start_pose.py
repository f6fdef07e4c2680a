"""Settings of the start pose, under nav2's names."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from robot.covariance import CovarianceError, covariance_from
from robot.geometry import Array, Pose2
from robot.settings import SettingError, check_settings, setting


@dataclass(frozen=True)
class InitialPose:
    """Where the filter starts if set_initial_pose says so, in the map frame."""

    x: float = setting(0.0, "Place", unit="m", low=-1e4, high=1e4)
    y: float = setting(0.0, "Place", unit="m", low=-1e4, high=1e4)
    theta: float = setting(0.0, "Heading", unit="rad", low=-2 * math.pi, high=2 * math.pi)
    sd_xy: float = setting(0.1, "Spread of the place", unit="m", low=0.0001, high=100)
    sd_theta: float = setting(0.3, "Spread of the heading", unit="rad", low=0.0001, high=10)
    covariance: tuple[float, ...] = setting(
        (), "Nine numbers by rows [m², m rad, rad²], instead of the spreads"
    )

    def __post_init__(self) -> None:
        check_settings(self)
        try:
            self.matrix()
        except CovarianceError as error:
            raise SettingError(str(error)) from error

    @property
    def pose(self) -> Pose2:
        """Start pose in the map."""
        return Pose2(self.x, self.y, self.theta)

    def matrix(self) -> Array:
        """Return the covariance (3, 3) of x, y and theta [m², m rad, rad²]."""
        if self.covariance:
            return covariance_from(self.covariance)
        return np.diag(np.square([self.sd_xy, self.sd_xy, self.sd_theta]))


@dataclass(frozen=True)
class StartPoseSettings:
    """Where the filter starts, and what is kept for the next start."""

    set_initial_pose: bool = setting(
        False, "Start the filter at initial_pose instead of the field's start"
    )
    restore_pose: bool = setting(
        False, "Start where the last run on the same map ended, if that was saved"
    )
    save_pose_rate: float = setting(
        0.5,
        "How often the pose is saved while it changes; 0 or less (nav2's -1) is never",
        unit="Hz",
        low=-1,
        high=10,
    )
    pose_file: str = setting("", "Where the pose is saved; else in the user's state folder, by map")
    initial_pose: InitialPose = InitialPose()

    def __post_init__(self) -> None:
        check_settings(self)
