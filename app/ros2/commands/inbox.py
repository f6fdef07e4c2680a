"""The one door for commands from routes; they are checked as those of the page are."""

from __future__ import annotations

from pydantic import ValidationError

from app.engine.commands import check
from app.engine.program import Program
from app.messages.commands import Command, StopCommand
from app.messages.parsing import in_words
from app.ros2.commands.incoming import (
    INCOMING,
    SERVICES,
    STAMPED_TWIST,
    TWIST,
    IncomingTopic,
    Service,
)
from app.ros2.message_types import Message, MessageError, from_cdr
from app.ros2.source import TopicSource


class Inbox:
    """Takes messages from any thread and puts what they mean into the engine's queue."""

    def __init__(self, program: Program, source: TopicSource) -> None:
        self.source = source
        self._program = program

    def incoming(self) -> tuple[IncomingTopic, ...]:
        """The topics that are listened to; cmd_vel has one type, by setting."""
        unwanted = TWIST if self.source.settings.stamped_cmd_vel else STAMPED_TWIST
        return tuple(item for item in INCOMING if item.type != unwanted)

    def services(self) -> tuple[Service, ...]:
        """The services that are offered."""
        return SERVICES

    def take(self, name: str, type_name: str, message: Message | bytes) -> Command:
        """Carry out a message; returns the command that it was.

        What comes on cmd_vel and cannot be carried out stops the robot: it is not what was meant.

        Args:
            name: of the topic, without slash and namespace.
            type_name: that the sender gave it.
            message: as rosbags has it, or CDR with its header.

        Raises:
            MessageError, ValueError: no such topic or type, or it may not be done; says why.
        """
        try:
            topic = self._topic(name, type_name)
            if isinstance(message, bytes | memoryview):
                message = from_cdr(message, type_name)
            return self._do(topic, message)
        except ValueError:
            self.refuse(name)
            raise

    def refuse(self, name: str) -> None:
        """Stop the robot for what came on cmd_vel and could not even be read."""
        if name == "cmd_vel":
            self._program.engine.commands.put(StopCommand(type="stop"))

    def call(self, name: str, request: Message) -> Command:
        """Carry out a request to a service; returns the command that it was.

        Raises:
            MessageError, ValueError: no such service, or it may not be done; says why.
        """
        for service in self.services():
            if service.name == name:
                return self._do(service, request)
        valid = ", ".join(service.name for service in self.services())
        raise MessageError(f"{name} is no service; valid are {valid}")

    def _topic(self, name: str, type_name: str) -> IncomingTopic:
        valid = self.incoming()
        for topic in valid:
            if topic.name == name and topic.type == type_name:
                return topic
        listed = ", ".join(f"{topic.name} ({topic.type})" for topic in valid)
        raise MessageError(f"{name} ({type_name}) is not listened to; valid are {listed}")

    def _do(self, wanted: IncomingTopic | Service, message: Message) -> Command:
        try:
            command = wanted.command(self.source, message)
        except ValidationError as error:
            raise MessageError(f"{wanted.name}: {in_words(error)}") from error
        check(command, self._program)
        self._program.engine.commands.put(command)
        return command
