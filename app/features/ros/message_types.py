"""ROS 2 message types, which rosbags reads from their definitions; no ROS is needed.

A message is an instance of the class that ``message_class`` returns. Arrays of numbers are NumPy
arrays. The types are read at the first use, which takes 0.2 s.
"""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING, Any

from robot.errors import BrickPoseError

if TYPE_CHECKING:
    from rosbags.typesys.store import Typestore

Message = Any

MORE = {
    "nav2_msgs/msg/Particle": "geometry_msgs/Pose pose\nfloat64 weight\n",
    "nav2_msgs/msg/ParticleCloud": "std_msgs/Header header\nnav2_msgs/Particle[] particles\n",
    "nav2_msgs/action/NavigateToPose_Feedback": (
        "geometry_msgs/PoseStamped current_pose\nbuiltin_interfaces/Duration navigation_time\n"
        "builtin_interfaces/Duration estimated_time_remaining\nint16 number_of_recoveries\n"
        "float32 distance_remaining\n"
    ),
    "nav2_msgs/action/NavigateToPose_FeedbackMessage": (
        "unique_identifier_msgs/UUID goal_id\nnav2_msgs/action/NavigateToPose_Feedback feedback\n"
    ),
}
"""Message types of nav2 (Jazzy), which rosbags does not have."""

MORE_SERVICES = {
    "std_srvs/srv/Empty": "---\n",
    "nav2_msgs/srv/SetInitialPose": "geometry_msgs/PoseWithCovarianceStamped pose\n---\n",
    "nav_msgs/srv/GetPlan": (
        "geometry_msgs/PoseStamped start\ngeometry_msgs/PoseStamped goal\nfloat32 tolerance\n"
        "---\nnav_msgs/Path plan\n"
    ),
    "slam_toolbox/srv/SaveMap": (
        "std_msgs/String name\n---\nuint8 RESULT_SUCCESS=0\nuint8 RESULT_NO_MAP_RECEIEVD=1\n"
        "uint8 RESULT_UNDEFINED_FAILURE=255\nuint8 result\n"
    ),
    "slam_toolbox/srv/Pause": "---\nbool status\n",
    "slam_toolbox/srv/Reset": (
        "bool pause_new_measurements\n---\nuint8 RESULT_SUCCESS=0\nuint8 result\n"
    ),
}
"""Services of ROS 2, nav2 and slam_toolbox; their names are spelt as there."""


class MessageError(BrickPoseError, ValueError):
    """A message, type or request is invalid; says what is wrong and what is valid."""


@cache
def typestore() -> Typestore:
    """The store of all known types."""
    # Imported when the first message is made: most programs never make one.
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore  # noqa: PLC0415

    store = get_typestore(Stores.ROS2_JAZZY)
    for name, text in MORE.items():
        store.register(get_types_from_msg(text, name))
    for name, text in MORE_SERVICES.items():
        for half, fields in zip(("Request", "Response"), text.split("---\n"), strict=True):
            # Replace the name that rosbags gives: it names every type as a message.
            (described,) = get_types_from_msg(fields, name).values()
            store.register({f"{name}_{half}": described})
    return store


@cache
def message_class(type_name: str) -> type[Any]:
    """The class of a type such as ``nav_msgs/msg/Odometry``.

    Raises:
        MessageError: the type is unknown.
    """
    known = typestore().types
    if type_name not in known:
        package = type_name.split("/", maxsplit=1)[0]
        alike = sorted(name for name in known if name.startswith(f"{package}/"))
        valid = alike or sorted({name.split("/")[0] for name in known})
        raise MessageError(f"{type_name} is an unknown type; valid are {', '.join(valid)}")
    return known[type_name]


def new(type_name: str, **fields: Any) -> Message:
    """Make a message from all its fields."""
    return message_class(type_name)(**fields)


def to_cdr(message: Message, type_name: str) -> bytes:
    """Encode a message as XCDR1, little endian, with its encapsulation header of 4 bytes.

    Raises:
        MessageError: the type is unknown, or a field does not fit it.
    """
    message_class(type_name)
    try:
        return bytes(typestore().serialize_cdr(message, type_name))
    except Exception as error:  # rosbags' generated code may raise any exception
        raise MessageError(f"no {type_name}: {error}") from error


def from_cdr(data: bytes | memoryview, type_name: str) -> Message:
    """Decode a message from CDR with its encapsulation header.

    Raises:
        MessageError: the type is unknown, or the bytes are not a message of it.
    """
    message_class(type_name)
    try:
        return typestore().deserialize_cdr(data, type_name)
    except Exception as error:  # rosbags may raise any exception if bytes are damaged
        raise MessageError(f"{len(data)} bytes are no {type_name}: {error}") from error


@cache
def definition(type_name: str) -> str:
    """The definitions of a type and of all types in it, in MCAP's schema encoding ``ros2msg``."""
    message_class(type_name)
    return typestore().generate_msgdef(type_name, ros_version=2)[0]


@cache
def type_hash(type_name: str) -> str:
    """The hash ``RIHS01_...`` by which ROS 2 (from Iron on) compares types."""
    message_class(type_name)
    return str(typestore().hash_rihs01(type_name))
