"""The inbox for the commands of all routes; they are checked like those of the page."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import TYPE_CHECKING

from pydantic import ValidationError

from app.engine.driver import Driver
from app.engine.drivers import Drivers
from app.engine.problems import CLIENTS_LOG
from app.engine.program import Program
from app.engine.snapshot import Snapshot
from app.features.ros.incoming import (
    INCOMING,
    SERVICES,
    STAMPED_TWIST,
    TWIST,
    Answer,
    IncomingTopic,
    Service,
    cure_of_type,
)
from app.features.ros.message_types import Message, MessageError, from_cdr
from app.features.ros.source import TopicSource
from app.messages.commands import Command, in_words
from robot.errors import CommandError
from robot.localization.parameters import LocalizationParameters

if TYPE_CHECKING:
    from app.features.ros.plans import Plans


class Inbox:
    """Takes messages from any thread, and puts their commands into the engine's queue."""

    def __init__(
        self,
        program: Program,
        source: TopicSource,
        drivers: Drivers,
        carry_out: Callable[[Driver, Command], None] | None = None,
    ) -> None:
        """Make the entry of a program.

        Args:
            program: what is commanded.
            source: what commands are converted with.
            carry_out: takes checked commands, also those that are not the engine's; by default
                the engine takes all.
        """
        self.source = source
        self.drivers = drivers
        self._program = program
        self._put = carry_out or drivers.put

    def incoming(self) -> tuple[IncomingTopic, ...]:
        """The topics that the robot subscribes to; a setting chooses the type of cmd_vel."""
        unwanted = TWIST if self.source.settings.stamped_cmd_vel else STAMPED_TWIST
        return tuple(item for item in INCOMING if item.type != unwanted)

    def services(self) -> tuple[Service, ...]:
        """The services that the robot offers."""
        return SERVICES

    def take(self, name: str, type_name: str, message: Message | bytes, driver: Driver) -> Command:
        """Carry out the command in a message, and return it.

        A message on cmd_vel that cannot be carried out stops the robot, because its sender wanted
        something else than the present motion.

        Args:
            name: the topic's name, without slash and namespace.
            type_name: the topic's type, as the sender gave it.
            message: an object of rosbags, or CDR with its header.

        Raises:
            MessageError: there is no such topic or type, or the message is invalid; says why.
            CommandError: the command is not allowed; says why.
        """
        try:
            topic = self._topic(name, type_name)
            if isinstance(message, bytes | memoryview):
                message = from_cdr(message, type_name)
            return self._do(topic, message, driver)
        except Exception:
            self.refuse(name, driver)
            raise

    def refuse(self, name: str, driver: Driver) -> None:
        """Stop the robot if the topic is cmd_vel: its message could not be read or carried out.

        It goes on if another client drives.
        """
        if name == "cmd_vel":
            self.drivers.refuse(driver)

    def call(self, name: str, request: Message, driver: Driver) -> Answer:
        """Carry out a request to a service, and return the fields of its answer.

        A slow service may take seconds.

        Raises:
            MessageError: there is no such service, or the request is invalid; says why.
            CommandError: the command is not allowed, and the answer has no field to tell that.
        """
        service = self._service(name)
        if service.command is None:
            return self._plans.answer(request)
        try:
            self._do(service, request, driver)
        except CommandError as refusal:
            answer = service.answer(refusal)
            CLIENTS_LOG.warning("%s refuses what %s asks: %s", name, driver.name, refusal)
            return answer
        return service.answer(None)

    @cached_property
    def _plans(self) -> Plans:
        from app.features.ros.plans import Plans  # noqa: PLC0415 - the first plan

        return Plans(self._program, self.source)

    def _service(self, name: str) -> Service:
        for service in self.services():
            if service.name == name:
                return service
        valid = ", ".join(service.name for service in self.services())
        raise MessageError(f"{name} is no service; valid are {valid}")

    def _topic(self, name: str, type_name: str) -> IncomingTopic:
        valid = self.incoming()
        for topic in valid:
            if topic.name == name and topic.type == type_name:
                return topic
        listed = ", ".join(f"{topic.name} ({topic.type})" for topic in valid)
        cures = (cure_of_type(name, topic.type, type_name) for topic in valid)
        raise MessageError(
            f"{name} ({type_name}) is not listened to; valid are {listed}{''.join(cures)}"
        )

    def _do(self, wanted: IncomingTopic | Service, message: Message, driver: Driver) -> Command:
        assert wanted.command is not None
        try:
            command = wanted.command(self.source, message)
        except ValidationError as error:
            raise MessageError(f"{wanted.name}: {in_words(error)}") from error
        self.carry_out(command, driver)
        return command

    def carry_out(self, command: Command, driver: Driver) -> None:
        """Check a command, and carry it out.

        Raises:
            CommandError: it is not allowed; says why.
        """
        self.drivers.check(driver, command, self._program)
        self._put(driver, command)

    @property
    def newest(self) -> Snapshot | None:
        """What the newest tick shows; None before the first one."""
        return self._program.engine.latest.get()

    def parameters(self) -> LocalizationParameters:
        """The filter's present parameters."""
        latest = self._program.engine.latest.get()
        return latest.filter.parameters if latest else self._program.config.localization
