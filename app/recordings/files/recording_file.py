"""The recording on the disk: a folder as ``ros2 bag`` makes it, written as things happen.

    NAME/NAME_0.mcap     messages, and all that a replay needs besides (attachments)
    NAME/metadata.yaml   for ROS 2's tools

What is written is readable at once: half a second of messages at a time goes to the file as a chunk
that is whole in itself. So a program that is killed, or a disk that is full, costs the last chunk.
"""

from __future__ import annotations

import errno
import os
from collections.abc import Mapping
from pathlib import Path
from typing import IO, Any, cast

from mcap.writer import Writer

from app.files import file_written_whole
from app.recordings.files.bag_metadata import (
    RecordedTopic,
    Span,
    as_text,
    bag_metadata,
    channel_metadata,
    in_file,
)
from app.recordings.files.recorded import RecordingError
from app.ros2.message_types import definition
from app.ros2.topic import Quality

PROFILE = "ros2"
SCHEMA_ENCODING = "ros2msg"
MESSAGE_ENCODING = "cdr"
METADATA_FILE = "metadata.yaml"

FLUSH_NS = 400_000_000
"""So much at most waits for the file, by the messages' log time."""

METADATA_NS = 5_000_000_000
"""``metadata.yaml`` is written anew so often."""

MOST_NAMES = 1000
"""Recordings that may begin in the same second."""


class RecordingFile:
    """A recording that is being written; one thread."""

    def __init__(self, folder: Path, facts: Mapping[str, str] | None = None) -> None:
        """Begin a recording.

        Args:
            folder: made for it; its name is that of the recording.
            facts: what is worth knowing: robot, map, seed, version.

        Raises:
            RecordingError: the folder is there already.
            OSError: it cannot be written.
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
        self._stream = _Stream(self.path)
        try:
            self._writer = Writer(cast(IO[Any], self._stream))
            self._writer.start(PROFILE, f"brickpose {self._facts.get('version', '')}".strip())
            if self._facts:
                self._writer.add_metadata("brickpose", self._facts)
            self.flush()
            self._write_metadata()
        except BaseException:
            self.abandon()
            raise

    @property
    def size(self) -> int:
        """Of the file [bytes]; what waits does not count."""
        return self._stream.good

    @property
    def duration(self) -> float:
        """From the first to the last message [s]."""
        return (self._span.end_ns - self._span.start_ns) / 1e9 if self._span else 0.0

    def attach(self, name: str, data: bytes, media_type: str, time_ns: int = 0) -> None:
        """Put a file in.

        Raises:
            OSError: it cannot be written.
        """
        self._writer.add_attachment(time_ns, time_ns, name, media_type, data)
        self.flush()

    def note(self, name: str, facts: Mapping[str, str]) -> None:
        """Put in a record of facts by name.

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
            topic: with its slash.
            type_name: as ``nav_msgs/msg/Odometry``.
            quality: of the topic.
            log_time_ns: when it was recorded [ns since 1970].
            publish_time_ns: of its content [ns since 1970].
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
        # A clock that was set back must not make the file wait until it has caught up.
        if abs(log_time_ns - self._flushed_ns) >= FLUSH_NS:
            self._flushed_ns = log_time_ns
            self.flush()
            self._write_metadata_now_and_then(log_time_ns)

    def flush(self) -> None:
        """Bring all that waits to the file.

        Raises:
            OSError: it cannot be written; what was written before remains.
        """
        self._writer.flush()  # type: ignore[no-untyped-call]
        self._stream.mark()

    def close(self) -> None:
        """Finish the file, with its index, and ``metadata.yaml``.

        Raises:
            OSError: they cannot be written; the messages before remain.
        """
        try:
            self.flush()
            self._writer.add_metadata("rosbag2", in_file(self._metadata()))
            self._writer.finish()  # type: ignore[no-untyped-call]
            self._stream.mark()
            self._write_metadata()
        finally:
            self._stream.close()

    def abandon(self) -> None:
        """Let go of a file that cannot be written any more; it ends with what was whole."""
        self._stream.close()

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

    def _write_metadata(self) -> None:
        # A file that was deleted takes all that is written, and nobody ever sees it.
        if not self.path.exists():
            raise FileNotFoundError(errno.ENOENT, "its file was deleted", str(self.path))
        with file_written_whole(self.folder / METADATA_FILE) as new:
            new.write_text(as_text(self._metadata()), encoding="utf-8")


def free_folder(parent: Path, name: str) -> Path:
    """A folder that is not there yet: of that name, or with a number behind it.

    Raises:
        RecordingError: there are too many.
    """
    for number in range(1, MOST_NAMES):
        folder = parent / (name if number == 1 else f"{name}-{number}")
        if not folder.exists():
            return folder
    raise RecordingError(f"{parent} has {MOST_NAMES} recordings called {name}; valid is another")


class _Stream:
    """A file without a buffer, which ends with what was whole when it cannot be written."""

    def __init__(self, path: Path) -> None:
        self._file = path.open("xb", buffering=0)
        self.good = 0
        """Up to here it is whole [bytes]."""

    def write(self, data: bytes) -> int:
        rest = memoryview(data)
        try:
            while rest:
                rest = rest[self._file.write(rest) :]
        except OSError:
            os.ftruncate(self._file.fileno(), self.good)
            self._file.seek(self.good)
            raise
        return len(data)

    def tell(self) -> int:
        return self._file.tell()

    def flush(self) -> None:
        """Nothing waits."""

    def mark(self) -> None:
        self.good = self._file.tell()

    def close(self) -> None:
        self._file.close()
