"""The files of a bag, each read message by message: MCAP, an SQLite database, or a ROS 1 bag."""

from __future__ import annotations

import shutil
import sqlite3
from collections import Counter
from collections.abc import Collection, Iterator
from contextlib import ExitStack, closing
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple, Protocol

import zstandard
from rosbags.rosbag1 import Reader as Ros1Reader
from rosbags.rosbag1.reader import Header, RecordType

from app.features.recordings.files.mcap_reader import open_recording
from app.features.recordings.files.recorded import CDR, ROS1
from robot.errors import BrickPoseError

TABLES = ("topics", "messages")
PENDING = ("-wal", "-journal")
"""Endings of the files in which SQLite keeps what is not in the database yet."""
WAL_MODE = b"\x02\x02"
"""Bytes 18 and 19 of a database whose newest messages are in a file beside it."""
ZSTD_MAGIC = b"\x28\xb5\x2f\xfd"
"""A message that begins so is compressed: in CDR, the first byte is 0."""
LARGEST_MESSAGE = 1 << 28
"""Largest message that is decompressed [bytes]."""


class BagError(BrickPoseError, ValueError):
    """The bag cannot be used; the message says what it has and what would be valid."""


@dataclass(frozen=True, slots=True)
class BagTopic:
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
    encoding: str
    """``CDR`` or ``ROS1``."""
    log_time_ns: int
    data: bytes


class Source(Protocol):
    """One file of a bag."""

    @property
    def topics(self) -> list[BagTopic]:
        """All topics."""
        ...

    @property
    def damages(self) -> list[str]:
        """Where messages are missing, in words, as far as was read until now."""
        ...

    @property
    def span_ns(self) -> tuple[int, int] | None:
        """When the first and the last message were recorded [ns]; None if there is none."""
        ...

    def messages(self, names: Collection[str], *, as_written: bool) -> Iterator[RawMessage]:
        """Yield the messages of some topics by the time of recording, or in the file's order."""
        ...


class McapSource:
    """An MCAP file; of a damaged one all whole chunks are read."""

    def __init__(self, path: Path) -> None:
        self._reader = open_recording(path, (CDR, ROS1))

    @property
    def topics(self) -> list[BagTopic]:
        """All topics; their messages are counted where the file does not say how many."""
        reader = self._reader
        counts: dict[str, int] = {}
        for name in reader.topics:
            count = reader.count(name)
            if count is None:
                counts = Counter(message.topic for message in reader.messages())
                break
            counts[name] = count
        return [BagTopic(name, kind, counts.get(name, 0)) for name, kind in reader.topics.items()]

    @property
    def damages(self) -> list[str]:
        """Where messages are missing, in words, as far as was read until now."""
        return self._reader.damages

    @property
    def span_ns(self) -> tuple[int, int] | None:
        """When the first and the last message were recorded [ns]."""
        reader = self._reader
        return (reader.start_ns, reader.end_ns) if reader.end_ns else None

    def messages(self, names: Collection[str], *, as_written: bool) -> Iterator[RawMessage]:
        """Yield the messages of some topics."""
        encodings = self._reader.encodings
        for item in self._reader.messages(names, as_written=as_written):
            encoding = encodings[item.topic]
            yield RawMessage(item.topic, item.type, encoding, item.log_time_ns, item.cdr)


class SqliteSource:
    """An SQLite database of rosbag2; what its metadata.yaml says of it does not matter."""

    def __init__(self, path: Path, stack: ExitStack) -> None:
        """Open the database until the stack is closed.

        Raises:
            BagError: it has no tables of a bag.
            sqlite3.Error: it cannot be read.
        """
        self._database = _connected(path, stack)
        held = {name for (name,) in self._rows("SELECT name FROM sqlite_master")}
        if not held.issuperset(TABLES):
            raise BagError(_no_tables(path))
        formats = self._rows("SELECT id, name, type, serialization_format FROM topics")
        self._topics = {number: (name, kind) for number, name, kind, form in formats if form == CDR}
        others = sorted({form for *_, form in formats if form != CDR})
        if others and not self._topics:
            raise BagError(f"{path} has messages in {', '.join(others)}; valid are those in {CDR}")
        self.damages: list[str] = []

    def _rows(self, query: str) -> list[Any]:
        return self._database.execute(query).fetchall()

    @property
    def topics(self) -> list[BagTopic]:
        """All topics."""
        counts = dict(self._rows("SELECT topic_id, count(*) FROM messages GROUP BY topic_id"))
        return [
            BagTopic(name, kind, counts.get(number, 0))
            for number, (name, kind) in self._topics.items()
        ]

    @property
    def span_ns(self) -> tuple[int, int] | None:
        """When the first and the last message were recorded [ns]."""
        ((start_ns, end_ns),) = self._rows("SELECT min(timestamp), max(timestamp) FROM messages")
        return None if start_ns is None else (start_ns, end_ns)

    def messages(self, names: Collection[str], *, as_written: bool) -> Iterator[RawMessage]:
        """Yield the messages of some topics."""
        chosen = [number for number, (name, _) in self._topics.items() if name in names]
        marks = ", ".join("?" for _ in chosen)
        order = "id" if as_written else "timestamp, id"
        query = (
            f"SELECT topic_id, timestamp, data FROM messages WHERE topic_id IN ({marks}) "
            f"ORDER BY {order}"
        )
        for number, log_time_ns, content in self._database.execute(query, chosen):
            name, kind = self._topics[number]
            yield RawMessage(name, kind, CDR, log_time_ns, content)


def _connected(path: Path, stack: ExitStack) -> sqlite3.Connection:
    """Connect to a database, with all that lies beside it; the bag itself is never changed."""
    pending = [path.with_name(path.name + ending) for ending in PENDING]
    pending = [file for file in pending if file.is_file() and file.stat().st_size]
    address = f"{path.absolute().as_uri()}?immutable=1"
    if pending:
        # To read such files, SQLite writes beside them; so they are copied.
        folder = Path(stack.enter_context(TemporaryDirectory(prefix="brickpose")))
        for file in (path, *pending):
            shutil.copyfile(file, folder / file.name)
        address = (folder / path.name).as_uri()
    return stack.enter_context(closing(sqlite3.connect(address, uri=True)))


def _no_tables(path: Path) -> str:
    """Say why a database has no messages."""
    with path.open("rb") as file:
        waits = file.read(20)[18:] == WAL_MODE
    if waits:
        return (
            f"{path} has no table of messages yet: they are in {path.name}-wal, which is missing; "
            "valid is the database with that file beside it, as its recorder left them"
        )
    return f"{path} is no bag: it has no tables {' and '.join(TABLES)}; valid is one of ros2 bag"


class Ros1Source:
    """A ROS 1 bag."""

    def __init__(self, path: Path, stack: ExitStack) -> None:
        """Open the bag until the stack is closed."""
        self._reader = stack.enter_context(Ros1Reader(path))
        self.damages: list[str] = []

    @property
    def topics(self) -> list[BagTopic]:
        """All topics."""
        return [
            BagTopic(name, info.msgtype or info.connections[0].msgtype, info.msgcount)
            for name, info in self._reader.topics.items()
        ]

    @property
    def span_ns(self) -> tuple[int, int] | None:
        """When the first and the last message were recorded [ns]."""
        return self._reader.start_time, self._reader.end_time

    def messages(self, names: Collection[str], *, as_written: bool) -> Iterator[RawMessage]:
        """Yield the messages of some topics."""
        chosen = [item for item in self._reader.connections if item.topic in names]
        if not chosen:
            return
        read = self._as_written(chosen) if as_written else self._reader.messages(chosen)
        for connection, log_time_ns, content in read:
            yield RawMessage(
                connection.topic, connection.msgtype, ROS1, log_time_ns, bytes(content)
            )

    def _as_written(self, chosen: list[Any]) -> Iterator[tuple[Any, int, bytes]]:
        """Yield messages by their places in the file; rosbags knows their times alone."""
        reader = self._reader
        places = sorted(
            (entry.chunk_pos, entry.offset, entry.time, connection.id)
            for connection in chosen
            for entry in reader.indexes[connection.id]
        )
        by_number = {connection.id: connection for connection in chosen}
        unpacked, stream = -1, BytesIO()
        assert reader.bio is not None
        for chunk, offset, log_time_ns, number in places:
            if chunk != unpacked:
                reader.bio.seek(reader.chunks[chunk].datapos)
                packed = reader.bio.read(reader.chunks[chunk].datasize)
                unpacked, stream = chunk, BytesIO(reader.chunks[chunk].decompressor(packed))
            stream.seek(offset)
            while Header.read(stream).get_uint8("op") != RecordType.MSGDATA:
                stream.seek(_length(stream), 1)
            yield by_number[number], log_time_ns, stream.read(_length(stream))


def _length(stream: BytesIO) -> int:
    return int.from_bytes(stream.read(4), "little")


def plain(message: RawMessage) -> bytes:
    """Return a message's bytes, decompressed if the recorder compressed each message.

    Raises:
        zstandard.ZstdError: they are damaged.
    """
    if message.encoding != CDR or not message.data.startswith(ZSTD_MAGIC):
        return message.data
    if zstandard.frame_content_size(message.data) > LARGEST_MESSAGE:
        raise zstandard.ZstdError(f"a message is larger than {LARGEST_MESSAGE} bytes")
    return zstandard.ZstdDecompressor().decompress(message.data, max_output_size=LARGEST_MESSAGE)
