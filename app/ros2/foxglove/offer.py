"""What the robot offers to every viewer of Foxglove: its topics and services."""

from __future__ import annotations

import secrets
from typing import Any

from app.ros2.foxglove.commands import ENCODINGS
from app.ros2.foxglove.protocol import words
from app.ros2.inbox import Inbox
from app.ros2.incoming import Service
from app.ros2.message_types import definition
from app.ros2.publisher import TopicPublisher
from app.ros2.rosbridge.names import Names
from app.ros2.topics import TOPICS


class Offer:
    """What all sessions share; a channel's number is the topic's place in ``topics``."""

    def __init__(self, publisher: TopicPublisher, inbox: Inbox) -> None:
        self.publisher = publisher
        self.inbox = inbox
        self.names = Names(inbox)
        self.topics = tuple(topic for topic in TOPICS if topic.live)
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
