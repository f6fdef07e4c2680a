"""Server of Foxglove's own protocol, on its own port."""

from __future__ import annotations

import threading
from typing import TYPE_CHECKING, Any

from app.ros2.foxglove.commands import Commands
from app.ros2.inbox import Inbox
from app.ros2.message_types import definition
from app.ros2.publisher import TopicPublisher
from app.ros2.route import Pace, Route
from app.ros2.topic import Published, Topic
from app.ros2.topics import TOPICS
from app.settings.ros2 import Ros2Settings
from robot.errors import PackageError, PortError

if TYPE_CHECKING:
    from foxglove import Channel, Context
    from foxglove.websocket import ChannelView, Client, WebSocketServer

BACKLOG = 128
"""Most messages that wait for a slow viewer; beyond it, the oldest are dropped."""


class FoxgloveRoute(Route):
    """Publishes every live topic; a message is made only while a viewer subscribes to its topic."""

    name = "Foxglove"

    def __init__(
        self, publisher: TopicPublisher, inbox: Inbox, settings: Ros2Settings, host: str
    ) -> None:
        self.failure: str | None = None
        """Why it does not run, if it failed."""
        self._publisher = publisher
        self._inbox = inbox
        self._settings = settings
        self._host = host
        self._server: WebSocketServer | None = None
        self._context: Context | None = None
        self._channels: dict[str, Channel] = {}
        self._paces: dict[str, Pace] = {}
        self._lock = threading.Lock()

    @property
    def port(self) -> int | None:
        """The port that the server listens on; None while it does not."""
        return None if self._server is None else self._server.port

    def start(self) -> None:
        """Start the server.

        Raises:
            PackageError: the SDK is not installed.
            PortError: the port is in use, or the address does not belong to this machine.
        """
        foxglove = _sdk()
        # Keep the context: without it, its channels would be removed.
        self._context = context = foxglove.Context()
        topics = [topic for topic in TOPICS if topic.live]
        self._channels = {topic.name: self._channel(topic, context) for topic in topics}
        self._paces = {topic.name: self._pace() for topic in topics}
        self._server = self._listen(foxglove, context)
        self._publisher.add(self)

    def close(self) -> None:
        """Stop the server, and disconnect all viewers; may be called twice."""
        self._publisher.remove(self)
        with self._lock:
            server, self._server = self._server, None
            channels, self._channels = self._channels, {}
        if server is not None:
            server.stop()
        for channel in channels.values():
            channel.close()

    def wants(self, topic: Topic, stamp: float) -> bool:
        """Whether a viewer subscribes to the topic, and its content is due."""
        channel = self._channels.get(topic.name)
        watched = channel is not None and channel.has_sinks()
        return watched and self._paces[topic.name].due(topic, stamp)

    def take(self, published: Published) -> None:
        """Hand the message to the SDK, which sends it from its own threads."""
        channel = self._channels.get(published.topic.name)
        if channel is not None:
            channel.log(published.cdr, log_time=published.log_time_ns)

    def restart_pace(self, name: str) -> None:
        """Restart the pace of a topic, by its full name: a new subscriber gets latched content."""
        for topic in TOPICS:
            if self._settings.full_name(topic.name) == name:
                self._paces[topic.name] = self._pace()

    def _pace(self) -> Pace:
        return Pace(lambda topic: self._settings.period(topic.rate))

    def _channel(self, topic: Topic, context: Context) -> Channel:
        from foxglove import Channel, Schema  # noqa: PLC0415

        text = definition(topic.type).encode()
        schema = Schema(name=topic.type, encoding="ros2msg", data=text)
        name = self._settings.full_name(topic.name)
        return Channel(name, schema=schema, message_encoding="cdr", context=context)

    def _listen(self, foxglove: Any, context: Context) -> WebSocketServer:
        commands = Commands(self._inbox)
        listener = _Listener(self, commands)
        may = self._settings.foxglove_commands
        able = [foxglove.Capability.ClientPublish, foxglove.Capability.Services] if may else []
        try:
            server: WebSocketServer = foxglove.start_server(
                name="BrickPose",
                host=self._host,
                port=self._settings.foxglove_port,
                context=context,
                capabilities=able,
                supported_encodings=["cdr", "json"],
                services=commands.services() if may else None,
                server_listener=listener,
                message_backlog_size=BACKLOG,
            )
        except Exception as error:  # the SDK raises plain exceptions
            raise PortError(
                f"Foxglove cannot listen on {self._host} port {self._settings.foxglove_port}: "
                f"{error}; another port is chosen by ros2.foxglove_port"
            ) from error
        listener.server = server
        return server


class _Listener:
    """Callbacks of the SDK, which calls them in its own threads."""

    def __init__(self, route: FoxgloveRoute, commands: Commands) -> None:
        self.server: WebSocketServer | None = None
        self._route = route
        self._commands = commands

    def on_subscribe(self, client: Client, channel: ChannelView) -> None:
        self._route.restart_pace(channel.topic)

    def on_unsubscribe(self, client: Client, channel: ChannelView) -> None:
        """Do nothing; the SDK calls it in any case."""

    def on_client_advertise(self, client: Client, channel: Any) -> None:
        self._say(self._commands.advertise(client.id, channel))

    def on_client_unadvertise(self, client: Client, client_channel_id: int) -> None:
        self._commands.unadvertise(client.id, client_channel_id)

    def on_message_data(self, client: Client, client_channel_id: int, data: bytes) -> None:
        self._say(self._commands.take(client.id, client_channel_id, data))

    def _say(self, complaint: str | None) -> None:
        if complaint is not None and self.server is not None:
            from foxglove import StatusLevel  # noqa: PLC0415

            self.server.publish_status(complaint, StatusLevel.Error)


def _sdk() -> Any:
    try:
        import foxglove  # noqa: PLC0415
        import foxglove.websocket  # noqa: PLC0415
    except ImportError as error:
        raise PackageError(
            "Foxglove needs its SDK: pip install 'brickpose[foxglove]' "
            f"(.venv/bin/pip in a checkout); {error}"
        ) from error
    return foxglove
