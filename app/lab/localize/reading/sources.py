"""Files of a bag, whichever library reads them: their topics, and their undecoded messages."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterator
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple, Protocol

from rosbags.rosbag1 import Reader as Ros1Reader
from rosbags.rosbag2 import Reader as Ros2Reader

from app.recordings.files.mcap_reader import open_recording


@dataclass(frozen=True, slots=True)
class Topic:
    """One topic of a bag."""

    name: str
    type: str
    """Such as ``sensor_msgs/msg/LaserScan``."""
    count: int
    """Number of messages."""


class RawMessage(NamedTuple):
    """One message as its bytes."""

    topic: str
    type: str
    log_time_ns: int
    data: bytes


class Source(Protocol):
    """One file of a bag, or its folder."""

    @property
    def topics(self) -> list[Topic]:
        """All topics."""
        ...

    @property
    def damages(self) -> list[str]:
        """Where messages are missing, in words, as far as was read until now."""
        ...

    def messages(self, names: Collection[str]) -> Iterator[RawMessage]:
        """Yield the messages of some topics in recorded order."""
        ...


class McapSource:
    """An MCAP file or a folder of them; of a damaged one all whole chunks are read."""

    def __init__(self, path: Path) -> None:
        self._reader = open_recording(path)

    @property
    def topics(self) -> list[Topic]:
        """All topics; their messages are counted where the file does not say how many."""
        reader = self._reader
        counts: dict[str, int] = {}
        for name in reader.topics:
            count = reader.count(name)
            if count is None:
                counts = Counter(message.topic for message in reader.messages())
                break
            counts[name] = count
        return [Topic(name, kind, counts.get(name, 0)) for name, kind in reader.topics.items()]

    @property
    def damages(self) -> list[str]:
        """Where messages are missing, in words, as far as was read until now."""
        return self._reader.damages

    def messages(self, names: Collection[str]) -> Iterator[RawMessage]:
        """Yield the messages of some topics in recorded order."""
        for message in self._reader.messages(names):
            yield RawMessage(message.topic, message.type, message.log_time_ns, message.cdr)


class RosbagsSource:
    """A bag that rosbags reads: of ROS 1, or in an SQLite database."""

    damages: list[str]

    def __init__(self, path: Path, stack: ExitStack, *, ros1: bool) -> None:
        """Open the bag until the stack is closed."""
        self._reader: Any = stack.enter_context(Ros1Reader(path) if ros1 else Ros2Reader(path))
        self.damages = []

    @property
    def topics(self) -> list[Topic]:
        """All topics."""
        return [
            Topic(name, info.msgtype or info.connections[0].msgtype, info.msgcount)
            for name, info in self._reader.topics.items()
        ]

    def messages(self, names: Collection[str]) -> Iterator[RawMessage]:
        """Yield the messages of some topics in recorded order."""
        chosen = [item for item in self._reader.connections if item.topic in names]
        if chosen:
            for connection, logged, data in self._reader.messages(connections=chosen):
                yield RawMessage(connection.topic, connection.msgtype, logged, bytes(data))
