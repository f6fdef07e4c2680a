"""Carries out what Foxglove's viewers send: messages on topics, and requests to services."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

from app.engine.drivers import Driver
from app.ros2.inbox import Inbox
from app.ros2.incoming import Service
from app.ros2.message_types import (
    Message,
    MessageError,
    definition,
    from_cdr,
    message_class,
    to_cdr,
)
from app.ros2.rosbridge.names import Names
from app.ros2.rosbridge.values.fields import FILLER, fields
from app.ros2.rosbridge.values.reading import message_of
from robot.errors import BrickPoseError

if TYPE_CHECKING:
    from foxglove import MessageSchema, ServiceRequest
    from foxglove import Service as OfferedService

MOST_CHANNELS = 1000
"""Most open channels of all viewers; they need only a few. Beyond it, the oldest is dropped."""


class Commands:
    """The viewers' commands; called from any thread of the SDK."""

    def __init__(self, inbox: Inbox) -> None:
        self._inbox = inbox
        self._names = Names(inbox)
        self._channels: dict[tuple[int, int], tuple[str, str, str]] = {}
        """Topic, type and encoding by viewer and channel."""
        self._drivers: dict[int, Driver] = {}

    def advertise(self, client: int, channel: Any) -> str | None:
        """Register a viewer's channel; return an error message if it is not allowed."""
        try:
            topic = self._names.incoming_topic(channel.topic, channel.schema_name)
        except MessageError as error:
            return str(error)
        if len(self._channels) >= MOST_CHANNELS:
            self._channels.pop(next(iter(self._channels)))
        self._channels[client, channel.id] = (topic.name, topic.type, channel.encoding)
        return None

    def unadvertise(self, client: int, channel: int) -> None:
        """Remove a viewer's channel."""
        self._channels.pop((client, channel), None)

    def take(self, client: int, channel: int, data: bytes) -> str | None:
        """Carry out a message; return an error message if that is not possible."""
        known = self._channels.get((client, channel))
        if known is None:
            return None  # refused when it was advertised
        name, type_name, encoding = known
        try:
            try:
                message = _decoded(data, type_name, encoding)
            except MessageError:
                self._inbox.refuse(name, self._driver(client))
                raise
            self._inbox.take(name, type_name, message, self._driver(client))
        except BrickPoseError as error:
            return str(error)
        return None

    def _driver(self, client: int) -> Driver:
        if client not in self._drivers:
            self._drivers[client] = Driver.numbered("Foxglove")
        return self._drivers[client]

    def services(self) -> list[OfferedService]:
        """The services as objects of the SDK."""
        return [self._offered(service) for service in self._inbox.services()]

    def _offered(self, service: Service) -> OfferedService:
        from foxglove import Service as Offered  # noqa: PLC0415
        from foxglove import ServiceSchema  # noqa: PLC0415

        def answer(request: ServiceRequest) -> bytes:
            message = _decoded(request.payload, f"{service.type}_Request", request.encoding)
            self._inbox.call(service.name, message, self._driver(request.client_id))
            return _empty(service, request.encoding)

        schema = ServiceSchema(
            service.type,
            request=_schema(f"{service.type}_Request"),
            response=_schema(f"{service.type}_Response"),
        )
        name = self._names.settings.full_name(service.name)
        return Offered(name, schema=schema, handler=answer)


def _decoded(data: bytes, type_name: str, encoding: str) -> Message:
    if not fields(type_name):
        return message_of({}, type_name)  # some viewers send one byte, others send none
    if encoding == "cdr":
        return from_cdr(data, type_name)
    if encoding != "json":
        raise MessageError(f"the encoding is {encoding!r}; valid are cdr and json")
    try:
        values = json.loads(data)
    except (ValueError, RecursionError) as error:
        raise MessageError(f"no JSON: {str(error)[:100]}") from None
    return message_of(values, type_name)


def _empty(service: Service, encoding: str) -> bytes:
    """The answer of every service: an empty message, as in nav2."""
    if encoding == "json":
        return b"{}"
    type_name = f"{service.type}_Response"
    return to_cdr(message_class(type_name)(**{FILLER: 0}), type_name)


def _schema(type_name: str) -> MessageSchema:
    from foxglove import MessageSchema, Schema  # noqa: PLC0415

    text = definition(type_name).encode()
    return MessageSchema(
        encoding="cdr", schema=Schema(name=type_name, encoding="ros2msg", data=text)
    )
