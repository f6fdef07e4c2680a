"""The objects that all clients of rosbridge share."""

from __future__ import annotations

from typing import Any

from app.ros2.inbox import Inbox
from app.ros2.incoming import Service
from app.ros2.message_types import Message, MessageError
from app.ros2.publisher import TopicPublisher
from app.ros2.rosbridge.encoding import Encoder
from app.ros2.rosbridge.fields import fields
from app.ros2.rosbridge.names import Names
from app.ros2.rosbridge.reading import message_of
from app.ros2.rosbridge.rosapi import RosApi


class Bridge:
    """One robot, as all clients see it."""

    def __init__(self, publisher: TopicPublisher, inbox: Inbox) -> None:
        self.publisher = publisher
        self.inbox = inbox
        self.names = Names(inbox)
        self.rosapi = RosApi(self.names)
        self.encoder = Encoder()

    def service(self, name: str) -> Service:
        """Return a service that a client calls.

        Raises:
            MessageError: there is no service of that name; lists the valid names.
        """
        result = self.names.service(name)
        if result is None:
            valid = ", ".join([*self.names.service_types(), *self.rosapi.names()])
            raise MessageError(f"{name} is no service; valid are {valid}")
        return result

    def request_of(self, service: Service, arguments: Any) -> Message:
        """Make a request from its arguments: fields by name, or a list in the order of the fields.

        Raises:
            MessageError: the arguments do not fit the service.
        """
        type_name = f"{service.type}_Request"
        if isinstance(arguments, list):
            names = list(fields(type_name))
            if len(arguments) > len(names):
                raise MessageError(f"{service.name} takes {len(names)} arguments")
            arguments = dict(zip(names, arguments, strict=False))
        return message_of(arguments, type_name)
