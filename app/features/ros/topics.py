"""What a topic is, and all topics; their names and frames follow nav2 and RViz."""

from __future__ import annotations

import threading
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, cached_property

from app.engine.plugging import plugged
from app.engine.snapshot import Snapshot
from app.feature import Feature
from app.feature_search import Features
from app.features.ros.encoding import motion, navigation, robot_state, sensors
from app.features.ros.message_types import Message, from_cdr, message_class, to_cdr
from app.features.ros.source import UNCHANGING, TopicSource


@dataclass(frozen=True, slots=True)
class Quality:
    """Quality of service, as a publisher offers it (REP-2003; nav2)."""

    reliable: bool = True
    """It also matches subscribers that ask for best effort; the other way round does not match."""
    latched: bool = False
    """Late subscribers get the last message (transient local)."""
    depth: int = 10


LATCHED = Quality(latched=True, depth=1)


@dataclass(frozen=True, slots=True)
class Topic:
    """One entry of the list of topics."""

    name: str
    """Without a leading slash, as ``camera/camera_info``."""
    type: str
    """As ``sensor_msgs/msg/LaserScan``."""
    stamp: Callable[[Snapshot], float | None]
    """Stamp of the content, on the robot's clock [s]; None while there is no content. The same
    stamp means the same content."""
    make: Callable[[TopicSource, Snapshot], Message | bytes]
    """Makes the message, or its CDR where that is faster."""
    rate: str | None = None
    """The setting that limits its rate on live routes; None for no limit."""
    quality: Quality = Quality()
    live: bool = True
    """False: only recorded, because on live routes others publish it."""
    only_dds: bool = False
    """True: a hidden topic of an action; recordings have the journey's commands, rosbridge has
    actions, and readers of recordings refuse names of such types."""


class Published:
    """A message as an object and as bytes; converted at the first use, from any thread."""

    def __init__(self, topic: Topic, stamp: float, source: TopicSource, snapshot: Snapshot) -> None:
        self.topic = topic
        self.stamp = stamp
        """Stamp of the content, on the robot's clock [s]."""
        self.log_time_ns = source.clock.ns(snapshot.stamp)
        """Time of the tick that published it, in ROS time."""
        self.time_ns = self.log_time_ns if stamp == UNCHANGING else source.clock.ns(stamp)
        """Time of the content, in ROS time; that of the tick if the content never changes."""
        self._made = topic.make(source, snapshot)
        self._lock = threading.RLock()

    @cached_property
    def cdr(self) -> bytes:
        """XCDR1, little endian, with its encapsulation header."""
        with self._lock:
            made = self._made
            return made if isinstance(made, bytes) else to_cdr(made, self.topic.type)

    @cached_property
    def message(self) -> Message:
        """The message as an object of rosbags."""
        with self._lock:
            made = self._made
            return from_cdr(made, self.topic.type) if isinstance(made, bytes) else made


TOPICS: tuple[Topic, ...] = (
    Topic("scan", "sensor_msgs/msg/LaserScan", sensors.scan_stamp, sensors.laser_scan),
    Topic("odom", "nav_msgs/msg/Odometry", motion.tick_stamp, motion.odometry, "publish_rate"),
    Topic("tf", "tf2_msgs/msg/TFMessage", motion.tick_stamp, motion.transforms, "publish_rate"),
    Topic(
        "tf_static",
        "tf2_msgs/msg/TFMessage",
        motion.calibration_stamp,
        motion.static_transforms,
        quality=LATCHED,
    ),
    Topic(
        "amcl_pose",
        "geometry_msgs/msg/PoseWithCovarianceStamped",
        motion.estimate_stamp,
        motion.amcl_pose,
        quality=LATCHED,
    ),
    Topic(
        "particle_cloud",
        "nav2_msgs/msg/ParticleCloud",
        motion.tick_stamp,
        motion.particle_cloud,
        "cloud_rate",
    ),
    Topic(
        "particlecloud",
        "geometry_msgs/msg/PoseArray",
        motion.tick_stamp,
        motion.pose_array,
        "cloud_rate",
    ),
    Topic(
        "map",
        "nav_msgs/msg/OccupancyGrid",
        sensors.map_stamp,
        sensors.occupancy_grid,
        quality=LATCHED,
    ),
    Topic(
        "joint_states",
        "sensor_msgs/msg/JointState",
        motion.tick_stamp,
        motion.joint_states,
        "publish_rate",
    ),
    Topic(
        "camera/image/compressed",
        "sensor_msgs/msg/CompressedImage",
        sensors.picture_stamp,
        sensors.compressed_image,
        "picture_rate",
    ),
    Topic(
        "camera/camera_info",
        "sensor_msgs/msg/CameraInfo",
        sensors.picture_stamp,
        sensors.camera_info,
        "picture_rate",
    ),
    Topic(
        "robot_description",
        "std_msgs/msg/String",
        motion.calibration_stamp,
        robot_state.robot_description,
        quality=LATCHED,
    ),
    Topic(
        "battery_state",
        "sensor_msgs/msg/BatteryState",
        robot_state.battery_stamp,
        robot_state.battery_state,
    ),
    Topic(
        "diagnostics",
        "diagnostic_msgs/msg/DiagnosticArray",
        motion.each_second,
        robot_state.diagnostics,
    ),
    Topic(
        "truth",
        "geometry_msgs/msg/PoseStamped",
        motion.truth_stamp,
        motion.true_pose,
        "publish_rate",
    ),
    Topic("plan", "nav_msgs/msg/Path", navigation.plan_stamp, navigation.plan),
    Topic(
        "navigate_to_pose/_action/status",
        "action_msgs/msg/GoalStatusArray",
        navigation.goal_status_stamp,
        navigation.goal_status,
        quality=LATCHED,
        only_dds=True,
    ),
    Topic(
        "navigate_to_pose/_action/feedback",
        navigation.FEEDBACK,
        navigation.feedback_stamp,
        navigation.feedback,
        only_dds=True,
    ),
    Topic(
        "cmd_vel",
        "geometry_msgs/msg/TwistStamped",
        motion.tick_stamp,
        motion.applied_velocity,
        live=False,
    ),
    Topic(
        "initialpose",
        "geometry_msgs/msg/PoseWithCovarianceStamped",
        robot_state.initial_pose_stamp,
        robot_state.initial_pose,
        live=False,
    ),
    Topic(
        "goal_pose",
        "geometry_msgs/msg/PoseStamped",
        robot_state.goal_pose_stamp,
        robot_state.goal_pose,
        live=False,
    ),
    Topic(
        "command",
        "std_msgs/msg/String",
        robot_state.commands_stamp,
        robot_state.commands_as_json,
        live=False,
    ),
)


def topics() -> tuple[Topic, ...]:
    """Return all topics of this process: ours first, then those of features."""
    return _with_added(plugged().features)[0]


def feature_of(topic: Topic) -> str | None:
    """Return the name of the feature that adds a topic; None if it is ours."""
    return _with_added(plugged().features)[2].get(topic.name)


def topic_failures() -> tuple[str, ...]:
    """Return why the topics of some features cannot be used, for people."""
    return _with_added(plugged().features)[1]


@cache
def _with_added(
    features: Features,
) -> tuple[tuple[Topic, ...], tuple[str, ...], dict[str, str]]:
    names = {topic.name for topic in TOPICS}
    whose: dict[str, str] = {}

    def added(feature: Feature) -> list[Topic]:
        new = [topic for make in feature.topics for topic in make()]
        for topic in new:
            if not isinstance(topic, Topic):
                raise TypeError(f"a topic is {topic!r}; valid is a Topic")
            message_class(topic.type)
        for name, count in Counter([*names, *(topic.name for topic in new)]).items():
            if count > 1:
                raise ValueError(f"there is a topic {name!r} already")
        names.update(topic.name for topic in new)
        whose.update({topic.name: feature.name for topic in new})
        return new

    usable, failures = features.made(added)
    return (*TOPICS, *usable), tuple(failures), whose
