"""Writes a recording to the disk while it is made: a folder as ``ros2 bag`` makes it.

    NAME/NAME_0.mcap     messages, and attachments with all else that a replay needs
    NAME/metadata.yaml   for ROS 2's tools

What is written is readable at once: 0.4 s of messages at a time go to the file as one complete
chunk. So if the program is killed or the disk is full, only the last chunk is lost.
"""

from __future__ import annotations

import errno
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import IO, Any, cast

from mcap.data_stream import RecordBuilder
from mcap.records import Channel, Schema
from mcap.writer import Writer

from app.features.recordings.files.bag_metadata import (
    RecordedTopic,
    Span,
    as_text,
    bag_metadata,
    channel_metadata,
    in_file,
)
from app.features.recordings.files.mcap_index import index_of
from app.features.recordings.files.mcap_records import CHANNELS
from app.features.recordings.files.recorded import RecordingError
from app.features.recordings.files.reserved_stream import ReservedStream
from app.features.ros.message_types import definition
from app.features.ros.topics import Quality
from app.files import atomic_file

PROFILE = "ros2"
SCHEMA_ENCODING = "ros2msg"
MESSAGE_ENCODING = "cdr"
METADATA_FILE = "metadata.yaml"

FLUSH_NS = 400_000_000
"""Longest time that messages wait to be written, by their log time [ns]."""

METADATA_NS = 5_000_000_000
"""Interval of writing ``metadata.yaml`` again [ns]."""

RESERVE = 1 << 20
CHUNK_RESERVE = 400
"""Space on the disk that is kept for finishing the file, and more of it for each chunk that the
index will name [bytes]."""

MOST_NAMES = 1000
"""Limit of recordings that begin in the same second."""


class RecordingFile:
    """A recording that is being written; one thread."""

    def __init__(self, folder: Path, facts: Mapping[str, str] | None = None) -> None:
        """Begin a recording.

        Args:
            folder: made by this call; its name is that of the recording.
            facts: the most important facts: robot, map, seed, version.

        Raises:
            RecordingError: the folder exists already.
            OSError: the folder cannot be written.
        """
        try:
            folder.mkdir(parents=True)
        except FileExistsError as error:
            raise RecordingError(f"{folder} exists; valid is a new folder") from error
        self.folder = folder
        self.path = folder / f"{folder.name}_0.mcap"
        self._facts = dict(facts or {})
        self._topics: dict[str, tuple[int, RecordedTopic]] = {}
        self._schemas: dict[str, int] = {}
        self._span: Span | None = None
        self._flushed_ns = self._told_ns = 0
        self._repeated = 0
        """How many channels were repeated last, outside of the chunks."""
        self._repeat_at = 2
        """At how many chunks they are repeated next, if none is added before."""
        self._chunks = 0
        self._finished = False
        self._stream = ReservedStream(self.path)
        try:
            self._writer = Writer(cast(IO[Any], self._stream))
            self._writer.start(PROFILE, f"brickpose {self._facts.get('version', '')}".strip())
            if self._facts:
                self._writer.add_metadata("brickpose", self._facts)
            self.flush()
            self._write_metadata()
            self._stream.reserve(RESERVE)
        except BaseException:
            self._stream.close()
            raise

    @property
    def size(self) -> int:
        """Size of the file [bytes], without messages that wait."""
        return self._stream.good

    @property
    def duration(self) -> float:
        """From the first to the last message [s]."""
        return (self._span.end_ns - self._span.start_ns) / 1e9 if self._span else 0.0

    def attach(self, name: str, data: bytes, media_type: str, time_ns: int = 0) -> None:
        """Add a file as an attachment.

        Raises:
            OSError: it cannot be written.
        """
        self._writer.add_attachment(time_ns, time_ns, name, media_type, data)
        self.flush()

    def note(self, name: str, facts: Mapping[str, str]) -> None:
        """Add a named record of facts.

        Raises:
            OSError: it cannot be written.
        """
        self._writer.add_metadata(name, dict(facts))
        self.flush()

    def write(
        self,
        topic: str,
        type_name: str,
        quality: Quality,
        log_time_ns: int,
        publish_time_ns: int,
        cdr: bytes,
    ) -> None:
        """Add a message.

        Args:
            topic: its name, with a leading slash.
            type_name: as ``nav_msgs/msg/Odometry``.
            log_time_ns: when it was recorded [ns since 1970].
            publish_time_ns: time of its content [ns since 1970].
            cdr: the message with its encapsulation header.

        Raises:
            MessageError: the type is unknown.
            OSError: it cannot be written; what was written before remains.
        """
        if topic not in self._topics:
            self._add_topic(RecordedTopic(topic, type_name, quality))
        channel, known = self._topics[topic]
        self._writer.add_message(channel, log_time_ns, cdr, publish_time_ns, known.count)
        known.count += 1
        if self._span is None:
            self._span = Span(log_time_ns, log_time_ns)
            self._flushed_ns = log_time_ns
        self._span.add(log_time_ns)
        # If the clock is set back, the file must not wait until it has caught up.
        if abs(log_time_ns - self._flushed_ns) >= FLUSH_NS:
            self._flushed_ns = log_time_ns
            self.flush()
            self._write_metadata_now_and_then(log_time_ns)

    def flush(self) -> None:
        """Write all waiting messages to the file.

        Raises:
            OSError: it cannot be written; what was written before remains.
        """
        self._writer.flush()  # type: ignore[no-untyped-call]
        self._stream.mark()
        self._chunks += 1
        if self._topics and (self._repeated < len(self._topics) or self._chunks >= self._repeat_at):
            self._repeated, self._repeat_at = len(self._topics), 2 * self._chunks
            self._repeat_channels()
        if self._stream.full is not None:
            raise self._stream.full

    def _repeat_channels(self) -> None:
        """Write schemas and channels outside of the chunks, too.

        The writer puts them in the chunk of their first message: without this, the damage of one
        chunk loses them for all others. They are repeated where the file has grown to twice its
        chunks, so that they stand far apart.
        """
        builder = RecordBuilder()
        for kind, number in self._schemas.items():
            text = definition(kind).encode()
            Schema(id=number, name=kind, encoding=SCHEMA_ENCODING, data=text).write(builder)
        for number, topic in self._topics.values():
            Channel(
                id=number, topic=topic.name, message_encoding=MESSAGE_ENCODING,
                metadata=channel_metadata(topic), schema_id=self._schemas[topic.type],
            ).write(builder)  # fmt: skip
        self._stream.write(builder.end())  # type: ignore[no-untyped-call]
        named = {str(n): f"{t.name} {t.type}" for n, t in self._topics.values()}
        self._writer.add_metadata(CHANNELS, named)
        self._writer.flush()  # type: ignore[no-untyped-call]
        self._stream.mark()

    def close(self) -> None:
        """Finish the file, with its index, and ``metadata.yaml``.

        Raises:
            OSError: something cannot be written; what was written before remains, as ``abandon``
                leaves it.
        """
        try:
            try:
                self.flush()
            except OSError:
                if not self._stream.whole:  # else all is written: only the disk is full
                    raise
            self._finish()
        except OSError:
            self.abandon()
            raise
        self._stream.close()

    def abandon(self) -> None:
        """Close a file that cannot be written any more; a closed one stays as it is.

        It is finished in the space that was kept for that; if it cannot be, it ends with its last
        complete record.
        """
        if self._stream.closed:
            return
        try:
            with suppress(OSError):
                if self._stream.full is not None and self._stream.whole:
                    self._finish()
                    return
            with suppress(OSError):
                self._count_again()
                self._write_metadata()
        finally:
            self._stream.close()

    def _finish(self) -> None:
        self._stream.release()
        if not self._finished:
            self._writer.add_metadata("rosbag2", in_file(self._metadata()))
            self._writer.finish()  # type: ignore[no-untyped-call]
            self._stream.mark()
            self._finished = True
        self._write_metadata()

    def _count_again(self) -> None:
        """Count only those messages that are in the file."""
        with self.path.open("rb") as file:
            index = index_of(file)
        for number, topic in self._topics.values():
            topic.count = index.counts[number]
        if index.pieces:
            start_ns = min(piece.start_ns for piece in index.pieces)
            self._span = Span(start_ns, max(piece.end_ns for piece in index.pieces))

    def _add_topic(self, topic: RecordedTopic) -> None:
        if topic.type not in self._schemas:
            text = definition(topic.type).encode()
            self._schemas[topic.type] = self._writer.register_schema(
                topic.type, SCHEMA_ENCODING, text
            )
        channel = self._writer.register_channel(
            topic.name, MESSAGE_ENCODING, self._schemas[topic.type], channel_metadata(topic)
        )
        self._topics[topic.name] = (channel, topic)
        self._told_ns = 0

    def _metadata(self) -> dict[str, Any]:
        topics = [topic for _, topic in self._topics.values()]
        return bag_metadata(self.path.name, topics, self._span, self._facts)

    def _write_metadata_now_and_then(self, now_ns: int) -> None:
        if abs(now_ns - self._told_ns) >= METADATA_NS:
            self._told_ns = now_ns
            self._write_metadata()
            self._stream.reserve(RESERVE + CHUNK_RESERVE * self._chunks)

    def _write_metadata(self) -> None:
        # A deleted file still accepts all writes, but nobody ever sees them.
        if not self.path.exists():
            raise FileNotFoundError(errno.ENOENT, "its file was deleted", str(self.path))
        with self._stream.noticing_full(), atomic_file(self.folder / METADATA_FILE) as new:
            new.write_text(as_text(self._metadata()), encoding="utf-8")


def free_folder(parent: Path, name: str) -> Path:
    """Return a folder that does not exist yet: with this name, or with a number behind it.

    Raises:
        RecordingError: there are too many folders of this name.
    """
    for number in range(1, MOST_NAMES):
        folder = parent / (name if number == 1 else f"{name}-{number}")
        if not folder.exists():
            return folder
    raise RecordingError(f"{parent} has {MOST_NAMES} recordings called {name}; valid is another")
