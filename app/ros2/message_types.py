"""ROS 2's message types, as rosbags knows them from their definitions; no ROS is needed.

A message is an instance of the class that ``message_class`` gives; numbers in arrays are numpy's.
The types are read at the first use, which takes 0.2 s.
"""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rosbags.typesys.store import Typestore

Message = Any

MORE = {
    "nav2_msgs/msg/Particle": "geometry_msgs/Pose pose\nfloat64 weight\n",
    "nav2_msgs/msg/ParticleCloud": "std_msgs/Header header\nnav2_msgs/Particle[] particles\n",
}
"""Of nav2 (Jazzy), which rosbags does not have."""

MORE_SERVICES = {
    "std_srvs/srv/Empty": "---\n",
    "nav2_msgs/srv/SetInitialPose": "geometry_msgs/PoseWithCovarianceStamped pose\n---\n",
}


class MessageError(ValueError):
    """No message of its type; says what is wrong and what is valid."""


@cache
def typestore() -> Typestore:
    """Every type that is known."""
    # Read when the first message is made: most programs never make one.
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore  # noqa: PLC0415

    store = get_typestore(Stores.ROS2_JAZZY)
    for name, text in MORE.items():
        store.register(get_types_from_msg(text, name))
    for name, text in MORE_SERVICES.items():
        for half, fields in zip(("Request", "Response"), text.split("---\n"), strict=True):
            # Not by the name that rosbags would give: it takes everything for a message.
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
    """A message with all its fields."""
    return message_class(type_name)(**fields)


def to_cdr(message: Message, type_name: str) -> bytes:
    """XCDR1, little endian, with the 4 bytes before it that tell so.

    Raises:
        MessageError: the type is unknown, or a field does not fit it.
    """
    message_class(type_name)
    try:
        return bytes(typestore().serialize_cdr(message, type_name))
    except Exception as error:  # rosbags raises whatever its generated code meets
        raise MessageError(f"no {type_name}: {error}") from error


def from_cdr(data: bytes | memoryview, type_name: str) -> Message:
    """The message in such bytes.

    Raises:
        MessageError: the type is unknown, or the bytes are none of it.
    """
    message_class(type_name)
    try:
        return typestore().deserialize_cdr(data, type_name)
    except Exception as error:  # damaged bytes make rosbags raise anything
        raise MessageError(f"{len(data)} bytes are no {type_name}: {error}") from error


@cache
def definition(type_name: str) -> str:
    """The type's definition with those of all types in it, as MCAP's ``ros2msg`` wants it."""
    message_class(type_name)
    return typestore().generate_msgdef(type_name, ros_version=2)[0]


@cache
def type_hash(type_name: str) -> str:
    """The hash ``RIHS01_...`` by which ROS 2 (from Iron) tells whether types are the same."""
    message_class(type_name)
    return str(typestore().hash_rihs01(type_name))
