"""Groups of settings: start pose, recordings, maps, topics of ROS 2."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from robot import user_folders
from robot.covariance import CovarianceError, covariance_from
from robot.geometry import Array, Pose2
from robot.settings import SettingError, check_settings, setting


def data_folder(folder: str, usual: str) -> Path:
    """Return a folder that is set, or the usual one in the user's data folder."""
    if folder:
        return Path(folder).absolute()
    return user_folders.data_folder() / usual


@dataclass(frozen=True)
class FeatureSettings:
    """Features, ours and other packages' (extending.md)."""

    without: tuple[str, ...] = setting((), "Names of features to leave out, as --without does")

    def __post_init__(self) -> None:
        check_settings(self)


@dataclass(frozen=True)
class InitialPose:
    """Where the filter starts if set_initial_pose says so, in the map frame."""

    x: float = setting(0.0, "x of the start pose", unit="m", low=-1e4, high=1e4)
    y: float = setting(0.0, "y of the start pose", unit="m", low=-1e4, high=1e4)
    theta: float = setting(
        0.0, "Heading of the start pose", unit="rad", low=-2 * math.pi, high=2 * math.pi
    )
    sd_xy: float = setting(0.1, "Standard deviation of x and y", unit="m", low=0.0001, high=100)
    sd_theta: float = setting(
        0.3, "Standard deviation of the heading", unit="rad", low=0.0001, high=10
    )
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


@dataclass(frozen=True)
class RecordingSettings:
    """Where recordings go, and how much is in them."""

    record: bool = setting(False, "Record from the start (--record DIR)")
    folder: str = setting("", "Where recordings are made; else in the user's data folder")
    picture_rate: float = setting(
        15.0, "Highest rate of pictures; 0 records every one", unit="Hz", low=0, high=1000
    )
    cloud_rate: float = setting(
        2.0, "Highest rate of particle clouds", unit="Hz", low=0.1, high=100
    )
    publish_rate: float = setting(
        20.0, "Highest rate of odom, tf and truth", unit="Hz", low=0.1, high=1000
    )

    def __post_init__(self) -> None:
        check_settings(self)

    def path(self) -> Path:
        """Return the folder for new recordings."""
        return data_folder(self.folder, "recordings")


@dataclass(frozen=True)
class MappingSettings:
    """Where maps go that the page saves."""

    folder: str = setting("", "Where maps are saved; else in the user's data folder")

    def __post_init__(self) -> None:
        check_settings(self)

    def path(self) -> Path:
        """Return the folder for new maps."""
        return data_folder(self.folder, "maps")


@dataclass(frozen=True)
class Ros2Settings:
    """Names, rates and reach of the topics."""

    dds: bool = setting(False, "Join ROS 2 as a node, over DDS (docs/ros2.md)")
    foxglove: bool = setting(False, "Serve Foxglove, at /foxglove on the same port (docs/ros2.md)")
    namespace: str = setting("", "Before the names of all topics, as in robot1/scan")
    domain_id: int = setting(
        -1, "Domain of DDS; -1 takes ROS_DOMAIN_ID, or 0 without it", low=-1, high=232
    )
    stamped_cmd_vel: bool = setting(
        True, "cmd_vel is a TwistStamped, as from Jazzy on; false: a Twist"
    )
    publish_rate: float = setting(
        20.0, "Highest rate of odom, tf, joint_states and truth", unit="Hz", low=0.1, high=1000
    )
    picture_rate: float = setting(10.0, "Highest rate of pictures", unit="Hz", low=0.1, high=1000)
    cloud_rate: float = setting(
        2.0, "Highest rate of particle clouds", unit="Hz", low=0.1, high=100
    )
    most_particles: int = setting(
        500, "Most particles of a published cloud; more are thinned evenly", low=1, high=20_000
    )
    jpeg_quality: int = setting(85, "JPEG quality of published pictures", low=1, high=100)
    tf_broadcast: bool = setting(
        True, "Tell map -> odom; false where another localization tells it, as nav2's amcl"
    )
    map_resolution: float = setting(
        0.005, "Side of a cell of the map, for a field of tape", unit="m", low=0.001, high=1
    )
    global_frame_id: str = setting("map", "The frame of the field")
    odom_frame_id: str = setting("odom", "The frame of odometry")
    base_frame_id: str = setting("base_footprint", "The robot's frame, on the floor below the axle")
    scan_frame_id: str = setting("base_scan", "The frame that scans start from")
    foxglove_commands: bool = setting(
        False, "Foxglove may drive, too, if its token does, and call services"
    )

    def __post_init__(self) -> None:
        check_settings(self)

    def full_name(self, topic: str) -> str:
        """Return a topic's name with slash and namespace, as ``/robot1/scan``."""
        parts = [part for part in (*self.namespace.split("/"), topic) if part]
        return "/" + "/".join(parts)
