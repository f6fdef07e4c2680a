"""Types, topics and services by the names that clients use."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from app.features.ros.inbox import Inbox
from app.features.ros.incoming import IncomingTopic, Service, cure_of_type
from app.features.ros.message_types import MessageError, message_class, typestore
from app.features.ros.topics import Topic, topics
from app.settings.groups import Ros2Settings

FILLER = "structure_needs_at_least_one_member"
"""The field that an empty type has in its bytes; no client ever sees it."""

NUMBERS: dict[str, np.dtype[Any]] = {
    **{f"int{bits}": np.dtype(f"int{bits}") for bits in (8, 16, 32, 64)},
    **{f"uint{bits}": np.dtype(f"uint{bits}") for bits in (8, 16, 32, 64)},
    "byte": np.dtype("int8"),  # as rosbags has it
    "char": np.dtype("uint8"),
    "bool": np.dtype("bool"),
    "float32": np.dtype("float32"),
    "float64": np.dtype("float64"),
}
"""Base types that are numbers, with NumPy's types for arrays of them."""


@dataclass(frozen=True, slots=True)
class FieldType:
    """The type of a field."""

    name: str
    """Name of a base type or of a message type."""
    nested: bool
    """Whether it is a message."""
    many: bool = False
    """Whether it is a list or an array of the named type."""
    length: int = 0
    """Length of an array; 0 means any length."""

    @property
    def item_kind(self) -> FieldType:
        """The type of one item of a list."""
        return FieldType(self.name, self.nested)


@cache
def fields(type_name: str) -> dict[str, FieldType]:
    """The fields of a message type, in their order.

    Raises:
        MessageError: the type is unknown.
    """
    message_class(type_name)
    described = typestore().fielddefs[type_name][1]
    return {name: _kind(description) for name, description in described if name != FILLER}


def _kind(description: Any) -> FieldType:
    from rosbags.interfaces import Nodetype  # noqa: PLC0415 -- as for the type store

    form, content = description
    if form == Nodetype.NAME:
        return FieldType(content, nested=True)
    if form == Nodetype.BASE:
        return FieldType(content[0], nested=False)
    inner = _kind(content[0])
    fixed = content[1] if form == Nodetype.ARRAY else 0
    return FieldType(inner.name, inner.nested, many=True, length=fixed)


def full_type(name: str, between: str) -> str:
    """Return a type's full name: ``geometry_msgs/msg/Twist`` for ROS 1's ``geometry_msgs/Twist``.

    Args:
        name: as a client gives it.
        between: ``msg`` or ``srv``.
    """
    package, slash, rest = name.partition("/")
    return name if not slash or "/" in rest else f"{package}/{between}/{rest}"


class Names:
    """The names of one robot, with and without the leading slash and the namespace."""

    def __init__(self, inbox: Inbox) -> None:
        self.settings = inbox.source.settings
        self.incoming = {topic.name: topic for topic in inbox.incoming()}
        self.outgoing = {topic.name: topic for topic in topics() if self._may_be_heard(topic)}
        self.services = {service.name: service for service in inbox.services()}
        self._plain = {
            spelling: name
            for name in (*self.incoming, *self.outgoing, *self.services)
            for spelling in spellings(name, self.settings)
        }

    def topic_types(self) -> dict[str, str]:
        """The type of each topic, by its full name; sorted."""
        types = {name: topic.type for name, topic in self.outgoing.items()}
        types |= {name: topic.type for name, topic in self.incoming.items()}
        return {self.settings.full_name(name): types[name] for name in sorted(types)}

    def service_types(self) -> dict[str, str]:
        """The type of each service, by its full name; sorted."""
        full = self.settings.full_name
        return {full(name): self.services[name].type for name in sorted(self.services)}

    def heard(self, name: str, type_name: str | None) -> Topic:
        """Return the topic that a client subscribes to.

        Raises:
            MessageError: there is no topic of that name and type.
        """
        topic = self.outgoing.get(self.plain(name))
        if topic is None:
            raise MessageError(f"{name} is no topic; valid are {self._listed(self.outgoing)}")
        check_type(topic, type_name)
        return topic

    def incoming_topic(self, name: str, type_name: str | None) -> IncomingTopic:
        """Return the topic that a client publishes on.

        Raises:
            MessageError: there is no topic of that name and type.
        """
        topic = self.incoming.get(self.plain(name))
        if topic is None:
            valid = self._listed(self.incoming)
            raise MessageError(f"nobody listens to {name}; valid are {valid}")
        check_type(topic, type_name)
        return topic

    def service(self, name: str) -> Service | None:
        """The service of that name; None if there is none."""
        return self.services.get(self.plain(name))

    def plain(self, name: str) -> str:
        """The name without slash and namespace; empty if it is unknown."""
        return self._plain.get(name, "")

    def _listed(self, names: dict[str, Topic] | dict[str, IncomingTopic]) -> str:
        return ", ".join(self.settings.full_name(name) for name in names)

    def _may_be_heard(self, topic: Topic) -> bool:
        """Whether clients may subscribe to the topic.

        Its actions tell them what the topics of actions do over DDS.
        A name has only one type: if cmd_vel is received as Twist, it is not sent as TwistStamped.
        """
        given = self.incoming.get(topic.name)
        return not topic.only_dds and (given is None or given.type == topic.type)


def check_type(topic: Topic | IncomingTopic | Service, type_name: str | None) -> None:
    """Refuse a type that differs from the topic's; None matches any type.

    Raises:
        MessageError: the type differs; names the right one.
    """
    between = "srv" if isinstance(topic, Service) else "msg"
    if not type_name:
        return
    wanted = full_type(type_name, between)
    if wanted != topic.type:
        cure = cure_of_type(topic.name, topic.type, wanted)
        raise MessageError(f"{topic.name} has the type {topic.type}, not {type_name[:100]}{cure}")


def spellings(name: str, settings: Ros2Settings) -> set[str]:
    """Return all ways in which clients may write a name."""
    full = settings.full_name(name)
    return {name, f"/{name}", full, full[1:]}
