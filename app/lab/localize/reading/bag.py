"""Read a ROS 1 bag, a ROS 2 bag or an MCAP file: its topics, and their messages one by one.

Only requested messages are decoded, with the definitions that all of ROS has in common. So the
other messages of a bag, and its own type definitions, do not matter.
"""

from __future__ import annotations

import heapq
import re
from collections import Counter
from collections.abc import Callable, Collection, Iterator
from contextlib import ExitStack
from dataclasses import astuple, dataclass
from pathlib import Path
from typing import Any, NamedTuple, Protocol

from rosbags.rosbag1 import Reader as Ros1Reader
from rosbags.rosbag2 import Reader as Ros2Reader
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from rosbags.typesys.store import Typestore

from app.recordings.files.mcap_reader import open_recording
from app.recordings.files.recorded import RecordingError
from robot.errors import BrickPoseError


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


OLD_NAMES = {"tf/msg/tfMessage": "tf2_msgs/msg/TFMessage"}
"""Types that were renamed without any change in content."""
STORAGE = (".mcap", ".db3")
ENDINGS = (".bag", *STORAGE)


class BagError(BrickPoseError, ValueError):
    """The bag cannot be used; the message says what it has and what would be valid."""


def message_types(*, ros1: bool) -> Typestore:
    """Return the message types that all robots have in common."""
    store = get_typestore(Stores.ROS1_NOETIC if ros1 else Stores.ROS2_HUMBLE)
    if ros1:  # the store lacks this type
        name = "tf2_msgs/msg/TFMessage"
        store.register(get_types_from_msg("geometry_msgs/TransformStamped[] transforms\n", name))
    return store


@dataclass(frozen=True, slots=True)
class Message:
    """One message."""

    topic: str
    logged: float
    """When it was recorded [s]."""
    content: Any
    """An object with the fields of the message type."""


class Bag:
    """An open bag; a context manager."""

    def __init__(self, path: Path) -> None:
        """Open a bag.

        Raises:
            BagError: there is no such file, or it is not a bag, damaged or cut short.
        """
        self.path = path
        self._stack = ExitStack()
        self._ros1 = path.suffix == ".bag" and path.is_file()
        store = message_types(ros1=self._ros1)
        self._decode: Callable[[bytes, str], Any] = (
            store.deserialize_ros1 if self._ros1 else store.deserialize_cdr
        )
        try:
            self._sources = [self._open(file) for file in _files(path)]
            self.topics = self._topics()
        except (BagError, RecordingError):
            raise
        except Exception as error:  # a foreign file may cause any error in the library
            raise BagError(f"{path} cannot be read: {_error_text(error)}. {_cure(path)}") from error

    def _open(self, path: Path) -> Source:
        if path.suffix == ".mcap" or (path.is_dir() and any(path.glob("*.mcap"))):
            return McapSource(path)
        return RosbagsSource(path, self._stack, ros1=self._ros1)

    def __enter__(self) -> Bag:
        return self

    def __exit__(self, *_: object) -> None:
        self._stack.close()

    def _topics(self) -> tuple[Topic, ...]:
        counts: Counter[tuple[str, str]] = Counter()
        for source in self._sources:
            for name, kind, count in map(astuple, source.topics):
                counts[name, OLD_NAMES.get(kind, kind)] += count
        return tuple(Topic(name, kind, count) for (name, kind), count in sorted(counts.items()))

    @property
    def damages(self) -> list[str]:
        """Where messages are missing, in words, as far as was read until now."""
        return [words for source in self._sources for words in source.damages]

    def of_type(self, kind: str) -> list[Topic]:
        """Return the topics of a type that have messages, by name."""
        return [topic for topic in self.topics if topic.type == kind and topic.count]

    def count(self, names: Collection[str]) -> int:
        """Return the number of messages of some topics."""
        return sum(topic.count for topic in self.topics if topic.name in names)

    def messages(self, names: Collection[str]) -> Iterator[Message]:
        """Yield the messages of some topics in recorded order, with one in memory at a time.

        Raises:
            BagError: the bag is damaged; of an MCAP file ``damages`` says what is missing.
        """
        try:
            parts = [self._decoded(source, names) for source in self._sources]
            yield from heapq.merge(*parts, key=lambda message: message.logged)
        except (GeneratorExit, RecordingError):
            raise
        except Exception as error:  # as above
            where = f"{self.path} is damaged or cut short: {_error_text(error)}"
            raise BagError(f"{where}. {_cure(self.path)}") from error

    def _decoded(self, source: Source, names: Collection[str]) -> Iterator[Message]:
        for topic, kind, logged, data in source.messages(names):
            yield Message(topic, 1e-9 * logged, self._decode(data, OLD_NAMES.get(kind, kind)))


def _files(path: Path) -> list[Path]:
    """Return the paths to open: the path itself, or the files of a folder without metadata."""
    if not path.exists():
        raise BagError(
            f"there is no {path}; valid is a .bag, .mcap or .db3 file, or a bag's folder"
        )
    if path.is_file():
        if path.suffix not in ENDINGS:
            raise BagError(f"{path} is no bag by its name; valid are {', '.join(ENDINGS)}")
        return [path]
    if (path / "metadata.yaml").is_file():
        return [path]
    parts = sorted((item for item in path.iterdir() if item.suffix in STORAGE), key=_natural)
    if not parts:
        raise BagError(
            f"the folder {path} has no metadata.yaml and no {' or '.join(STORAGE)} file; "
            "valid is a ROS 2 bag's folder"
        )
    return parts


def _natural(path: Path) -> list[tuple[int, str]]:
    """Return a sort key that puts part 10 after part 9."""
    return [(int(part or 0), word) for word, part in re.findall(r"(\D*)(\d*)", path.stem)]


def _error_text(error: Exception) -> str:
    text = str(error).strip().rstrip(".").splitlines()
    return text[0][:200] if text else type(error).__name__


def _cure(path: Path) -> str:
    """Return how to repair a bag whose writer was killed."""
    if path.suffix == ".bag":
        return "If it was not finished, `rosbag reindex` mends it"
    return "If it was not finished, `ros2 bag reindex` mends it"
