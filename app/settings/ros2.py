"""Settings of the robot's topics in ROS 2."""

from __future__ import annotations

from dataclasses import dataclass

from robot.settings import check_settings, setting


@dataclass(frozen=True)
class Ros2Settings:
    """Names, rates and reach of the topics."""

    dds: bool = setting(False, "Topics over DDS, for programs of ROS 2 (--ros2)")
    foxglove: bool = setting(False, "Topics for Foxglove and Lichtblick (--foxglove)")
    namespace: str = setting("", "Before the names of all topics, as in robot1/scan")
    domain_id: int = setting(
        -1, "Domain of DDS; -1 takes ROS_DOMAIN_ID, or 0 without it", low=-1, high=232
    )
    stamped_cmd_vel: bool = setting(
        True, "cmd_vel is a TwistStamped, as from Jazzy on; false: a Twist"
    )
    publish_rate: float = setting(
        20.0, "odom, tf, joint_states and truth at most so often", unit="Hz", low=0.1, high=1000
    )
    picture_rate: float = setting(10.0, "Pictures at most so often", unit="Hz", low=0.1, high=1000)
    cloud_rate: float = setting(
        2.0, "Clouds of particles at most so often", unit="Hz", low=0.1, high=100
    )
    most_particles: int = setting(500, "In a cloud, evenly chosen", low=1, high=20_000)
    jpeg_quality: int = setting(85, "Of pictures", low=1, high=100)
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

    def period(self, rate: str | None) -> float:
        """Return the least time between two messages [s]; 0: no limit.

        Args:
            rate: the name of the setting that limits the rate; None: no limit.
        """
        return 0.0 if rate is None else 1.0 / getattr(self, rate)
