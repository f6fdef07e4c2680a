"""What the robot offers to viewers of Foxglove, topics and services, and what viewers may send."""

from __future__ import annotations

import json
import secrets
from typing import Any

from app.engine.driver import Driver
from app.features.ros.foxglove.protocol import ClientChannel, ClientMessage, ServiceCall, words
from app.features.ros.inbox import Inbox
from app.features.ros.incoming import Answer, Service
from app.features.ros.message_types import Message, MessageError, definition, from_cdr, to_cdr
from app.features.ros.publisher import TopicPublisher
from app.features.ros.rosbridge.names import Names, fields
from app.features.ros.rosbridge.reading import message_of
from app.features.ros.topics import topics

MOST_CHANNELS = 100
"""Most open channels of a viewer, which needs only a few."""

ENCODINGS = ("cdr", "json")


class Commands:
    """The commands of one viewer."""

    def __init__(self, inbox: Inbox, names: Names, driver: Driver) -> None:
        self._inbox = inbox
        self._names = names
        self._driver = driver
        self._channels: dict[int, tuple[str, str, str]] = {}
        """Topic, type and encoding by channel."""

    def advertise(self, channel: ClientChannel) -> None:
        """Open a channel.

        Raises:
            MessageError: nobody listens to its topic and type, or there are too many.
        """
        topic = self._names.incoming_topic(channel.topic, channel.type)
        if len(self._channels) >= MOST_CHANNELS:
            raise MessageError(f"{MOST_CHANNELS} topics are advertised already")
        self._channels[channel.id] = (topic.name, topic.type, channel.encoding)

    def unadvertise(self, channel: int) -> None:
        """Close a channel."""
        self._channels.pop(channel, None)

    def take(self, message: ClientMessage) -> None:
        """Carry out a message on a channel; one on a channel that was refused has no effect.

        Raises:
            BrickPoseError: that is not possible; says why.
        """
        known = self._channels.get(message.channel)
        if known is None:
            return
        name, type_name, encoding = known
        try:
            content = _decoded(message.data, type_name, encoding)
        except MessageError:
            self._inbox.refuse(name, self._driver)
            raise
        self._inbox.take(name, type_name, content, self._driver)

    def call(self, request: ServiceCall) -> bytes:
        """Carry out a request to a service, and return its answer.

        Raises:
            BrickPoseError: that is not possible; says why.
        """
        services = self._inbox.services()
        if request.service >= len(services):
            raise MessageError(f"service {request.service} is not among those advertised")
        service = services[request.service]
        message = _decoded(request.data, f"{service.type}_Request", request.encoding)
        answer = self._inbox.call(service.name, message, self._driver)
        return _encoded(answer, f"{service.type}_Response", request.encoding)

    def is_slow(self, request: ServiceCall) -> bool:
        """Whether a request may take more than some milliseconds."""
        services = self._inbox.services()
        return request.service < len(services) and services[request.service].slow


def _decoded(data: bytes, type_name: str, encoding: str) -> Message:
    if encoding not in ENCODINGS:
        raise MessageError(f"the encoding is {encoding[:60]!r}; valid are {', '.join(ENCODINGS)}")
    if not fields(type_name):
        return message_of({}, type_name)  # some viewers send one byte, others send none
    if encoding == "cdr":
        return from_cdr(data, type_name)
    try:
        values = json.loads(data)
    except (ValueError, RecursionError) as error:
        raise MessageError(f"no JSON: {str(error)[:100]}") from None
    return message_of(values, type_name)


def _encoded(answer: Answer, type_name: str, encoding: str) -> bytes:
    if encoding == "json":
        return json.dumps(answer).encode()
    return to_cdr(message_of(answer, type_name), type_name)


class Offer:
    """What all sessions share; a channel's number is the topic's place in ``topics``."""

    def __init__(self, publisher: TopicPublisher, inbox: Inbox) -> None:
        self.publisher = publisher
        self.inbox = inbox
        self.names = Names(inbox)
        self.topics = tuple(topic for topic in topics() if topic.live and not topic.only_dds)
        self._session = secrets.token_hex(8)
        self._advertised = self._advertise_topics()

    def greetings(self, *, commands: bool) -> list[str]:
        """Return the first messages to a viewer, and whether it may send commands."""
        info = words(
            "serverInfo",
            name="BrickPose",
            capabilities=["clientPublish", "services"] if commands else [],
            supportedEncodings=list(ENCODINGS),
            metadata={},
            sessionId=self._session,
        )
        greetings = [info, self._advertised]
        return [*greetings, self._advertise_services()] if commands else greetings

    def _advertise_topics(self) -> str:
        channels = [
            {
                "id": number,
                "topic": self.names.settings.full_name(topic.name),
                "encoding": "cdr",
                "schemaName": topic.type,
                "schemaEncoding": "ros2msg",
                "schema": definition(topic.type),
            }
            for number, topic in enumerate(self.topics)
        ]
        return words("advertise", channels=channels)

    def _advertise_services(self) -> str:
        services = [self._service(*item) for item in enumerate(self.inbox.services())]
        return words("advertiseServices", services=services)

    def _service(self, number: int, service: Service) -> dict[str, Any]:
        return {
            "id": number,
            "name": self.names.settings.full_name(service.name),
            "type": service.type,
            "request": _schema(f"{service.type}_Request"),
            "response": _schema(f"{service.type}_Response"),
        }


def _schema(type_name: str) -> dict[str, str]:
    return {
        "encoding": "cdr",
        "schemaName": type_name,
        "schemaEncoding": "ros2msg",
        "schema": definition(type_name),
    }
