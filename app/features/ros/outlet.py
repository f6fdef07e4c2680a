"""The robot on ROS 2 as long as a program runs: topics over DDS, rosbridge and Foxglove."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING

from fastapi import APIRouter

from app.engine.command_row import Part
from app.features.ros.inbox import Inbox
from app.features.ros.publisher import TopicPublisher
from app.features.ros.source import TopicSource
from app.features.ros.topics import topic_failures
from app.features.ros.websocket_routes import Foxglove, Rosbridge, topics_router
from app.page.outlets import Outlet, Outlets

if TYPE_CHECKING:
    from app.features.ros.dds.route import DdsRoute

INBOX: Part[Inbox] = Part("inbox of topics")
PUBLISHER: Part[TopicPublisher] = Part("publisher of topics")


def publisher_of(outlets: Outlets) -> TopicPublisher:
    """Return what publishes a program's topics, once for all who take them."""
    program = outlets.program
    return outlets.shared(
        PUBLISHER, lambda: TopicPublisher(TopicSource.of(program), program.engine.every)
    )


class RosOutlet(Outlet):
    """Topics, services and parameters of one program."""

    def __init__(self, outlets: Outlets) -> None:
        """Prepare the routes that the settings ask for."""
        program = outlets.program
        settings = program.config.ros2
        self.publisher = publisher_of(outlets)
        self.inbox = Inbox(program, self.publisher.source, outlets.drivers, outlets.carry_out)
        self._rosbridge = Rosbridge(self.publisher, self.inbox)
        self._foxglove: Foxglove | None = None
        if settings.foxglove:
            self._foxglove = Foxglove(self.publisher, self.inbox, settings)
        self._dds: DdsRoute | None = None
        if settings.dds:
            from app.features.ros.dds.route import DdsRoute  # noqa: PLC0415 - needs an extra

            self._dds = DdsRoute(self.publisher, self.inbox, settings, program.config.host)

    @property
    def parts(self) -> Mapping[str, object]:
        """What takes commands by topic and service."""
        return {INBOX.name: self.inbox}

    @property
    def failures(self) -> Iterable[str]:
        """Why topics are late, lost or not to be had."""
        given = [self._dds and self._dds.failure, *self.publisher.failures, *topic_failures()]
        return [words for words in given if words]

    def routers(self) -> Iterable[APIRouter]:
        """Return the websockets of clients and viewers."""
        return (topics_router(self._rosbridge, self._foxglove),)

    def start(self) -> None:
        """Join the DDS network, if the settings ask for it."""
        if self._dds is not None:
            self._dds.start()

    def close(self) -> None:
        """Leave the network."""
        if self._dds is not None:
            self._dds.close()
