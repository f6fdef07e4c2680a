"""Read a ROS 1 bag, a ROS 2 bag or an MCAP file: its topics, and their messages one by one.

Only requested messages are decoded, with the definitions that all of ROS has in common. So the
other messages of a bag, and its own type definitions, do not matter.
"""

from __future__ import annotations

import heapq
from collections import Counter
from collections.abc import Callable, Collection, Iterator
from contextlib import ExitStack
from dataclasses import astuple, dataclass
from functools import cache
from itertools import chain, pairwise
from pathlib import Path
from typing import Any

from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from rosbags.typesys.store import Typestore

from app.features.lab.localize.reading.bag_files import (
    BagFiles,
    files_of,
    require_bag,
    several,
    unpacked,
)
from app.features.lab.localize.reading.sources import (
    BagError,
    BagTopic,
    McapSource,
    RawMessage,
    Ros1Source,
    Source,
    SqliteSource,
    plain,
)
from app.features.recordings.files.file_kinds import MCAP, SQLITE
from app.features.recordings.files.recorded import CDR, ROS1, RecordingError

OLD_NAMES = {"tf/msg/tfMessage": "tf2_msgs/msg/TFMessage"}
"""Types that were renamed without any change in content."""
LONGEST_PAUSE_S = 60.0
"""Files of one recording follow each other within this time [s]."""


@cache
def message_types(*, ros1: bool) -> Typestore:
    """Return the message types that all robots have in common."""
    store = get_typestore(Stores.ROS1_NOETIC if ros1 else Stores.ROS2_HUMBLE)
    if ros1:  # the store lacks this type
        name = "tf2_msgs/msg/TFMessage"
        store.register(get_types_from_msg("geometry_msgs/TransformStamped[] transforms\n", name))
    return store


@dataclass(frozen=True, slots=True)
class BagMessage:
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
        self._decoders: dict[str, Callable[[bytes, str], Any]] = {}
        self._undecoded: Counter[str] = Counter()
        """Number of messages by topic whose bytes are not of their type."""
        self._last_error = ""
        try:
            files = files_of(path)
            self._remarks = list(files.remarks)
            self._sources = [self._open(file) for file in files.paths]
            self._require_one_drive(files)
            self.topics = self._topics()
        except (BagError, RecordingError):
            self._stack.close()
            raise
        except Exception as error:  # a foreign file may cause any error in the library
            self._stack.close()
            raise BagError(f"{path} cannot be read: {_error_text(error)}. {_cure(path)}") from error

    def _open(self, file: Path) -> Source:
        whole, damage = unpacked(file, self._stack)
        if damage is not None:
            self._remarks.append(damage)
        ending = require_bag(whole)
        if ending == MCAP:
            return McapSource(whole)
        if ending == SQLITE:
            return SqliteSource(whole, self._stack)
        return Ros1Source(whole, self._stack)

    def _require_one_drive(self, files: BagFiles) -> None:
        """Raise BagError if files that nothing lists as one bag do not follow each other."""
        if files.listed:
            return
        spans = [source.span_ns for source in self._sources]
        for before, after in pairwise([span for span in spans if span is not None]):
            if not 0 <= after[0] - before[1] <= 1e9 * LONGEST_PAUSE_S:
                raise BagError(several(self.path, files.paths))

    def __enter__(self) -> Bag:
        return self

    def __exit__(self, *_: object) -> None:
        self._stack.close()

    def _topics(self) -> tuple[BagTopic, ...]:
        counts: Counter[tuple[str, str]] = Counter()
        for source in self._sources:
            for name, kind, count in map(astuple, source.topics):
                counts[name, _type_name(kind)] += count
        return tuple(BagTopic(name, kind, count) for (name, kind), count in sorted(counts.items()))

    @property
    def damages(self) -> list[str]:
        """What is missing or not as it should be, in words, as far as was read until now."""
        undecoded = [
            f"{count} messages on {topic} cannot be decoded: {self._last_error}"
            for topic, count in sorted(self._undecoded.items())
        ]
        missing = [words for source in self._sources for words in source.damages]
        return [*self._remarks, *missing, *undecoded]

    def of_type(self, kind: str) -> list[BagTopic]:
        """Return the topics of a type that have messages, by name."""
        return [topic for topic in self.topics if topic.type == kind and topic.count]

    def count(self, names: Collection[str]) -> int:
        """Return the number of messages of some topics."""
        return sum(topic.count for topic in self.topics if topic.name in names)

    def messages(self, names: Collection[str], *, as_written: bool = False) -> Iterator[BagMessage]:
        """Yield the messages of some topics in recorded order, with one in memory at a time.

        A message whose bytes are not of its type is left out; ``damages`` tells how many were.

        Args:
            names: the topics.
            as_written: in the order of the files, whatever the recorder's clock said.

        Raises:
            BagError: the bag is damaged; of an MCAP file ``damages`` says what is missing.
        """
        undecoded: Counter[str] = Counter()
        try:
            parts = [source.messages(names, as_written=as_written) for source in self._sources]
            merged = (
                chain.from_iterable(parts)
                if as_written
                else heapq.merge(*parts, key=lambda message: message.log_time_ns)
            )
            for raw in merged:
                message = self._decoded(raw)
                if message is not None:
                    yield message
                else:
                    undecoded[raw.topic] += 1
                    most = max(self._undecoded[raw.topic], undecoded[raw.topic])
                    self._undecoded[raw.topic] = most
        except (GeneratorExit, RecordingError):
            raise
        except Exception as error:  # as above
            where = f"{self.path} is damaged or cut short: {_error_text(error)}"
            raise BagError(f"{where}. {_cure(self.path)}") from error

    def _decoded(self, raw: RawMessage) -> BagMessage | None:
        try:
            decode = self._decoder(raw.encoding)
            content = decode(plain(raw), _type_name(raw.type))
        except Exception as error:
            self._last_error = _error_text(error)
            return None
        return BagMessage(raw.topic, 1e-9 * raw.log_time_ns, content)

    def _decoder(self, encoding: str) -> Callable[[bytes, str], Any]:
        if encoding not in self._decoders:
            store = message_types(ros1=encoding == ROS1)
            decode = store.deserialize_cdr if encoding == CDR else store.deserialize_ros1
            self._decoders[encoding] = decode
        return self._decoders[encoding]


def _type_name(name: str) -> str:
    """Return a type's name of today: ROS 1 has ``sensor_msgs/LaserScan``."""
    package, _, kind = name.partition("/")
    modern = name if "/" in kind else f"{package}/msg/{kind}"
    return OLD_NAMES.get(modern, modern)


def _error_text(error: Exception) -> str:
    text = str(error).strip().rstrip(".").splitlines()
    return text[0][:200] if text else type(error).__name__


def _cure(path: Path) -> str:
    """Return how to repair a bag whose writer was killed."""
    if path.suffix == ".bag":
        return "If it was not finished, `rosbag reindex` mends it"
    return "If it was not finished, `ros2 bag reindex` mends it"
