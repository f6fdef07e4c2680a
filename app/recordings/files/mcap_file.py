"""One MCAP file to read from."""

from __future__ import annotations

import heapq
from collections.abc import Collection, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO

from app.recordings.files.chunks import records_of
from app.recordings.files.mcap_index import Index, Piece, content_at, index_of, read_at
from app.recordings.files.mcap_records import (
    HEAD,
    MAGIC,
    MESSAGE,
    ChunkHead,
    DamageError,
    Opcode,
    split,
)
from app.recordings.files.recorded import RecordedMessage, RecordingError

OTHERS = {
    b"#ROSBAG V": "a ROS 1 bag",
    b"SQLite format 3": "an SQLite database, as older ROS 2 bags are",
    b"\x28\xb5\x2f\xfd": "compressed as a whole by zstd (unzstd unpacks it)",
    b"\x1f\x8b": "compressed as a whole by gzip (gunzip unpacks it)",
    b"PK\x03\x04": "a zip archive",
}
"""What files begin with that are taken for recordings."""

CDR = "cdr"


class McapFile:
    """What one file holds, found when it is made; opened anew for each reading."""

    def __init__(self, path: Path) -> None:
        """Look through the file.

        Raises:
            RecordingError: it is missing, no MCAP, or damaged from the beginning.
        """
        self.path = path
        with self._opened() as file:
            _check_beginning(path, file)
            self._index = index_of(file)
        index = self._index
        readable = {n: one for n, one in index.channels.items() if one.encoding == CDR}
        schemas = {n: index.schemas.get(one.schema) for n, one in readable.items()}
        self._names = {
            n: (readable[n].topic, schema.name) for n, schema in schemas.items() if schema
        }
        self.topics = dict(self._names.values())
        self.definitions = {
            schema.name: schema.text.decode(errors="replace")
            for schema in schemas.values()
            if schema
        }
        self.other_encodings = {one.encoding for one in index.channels.values()} - {CDR}
        self.metadata = index.metadata
        self.unfinished = not index.finished
        self.damage = index.damage

    @property
    def attachment_names(self) -> tuple[str, ...]:
        """Of all attachments."""
        return tuple(self._index.attachments)

    @property
    def times_ns(self) -> tuple[int, int] | None:
        """Log times of the first and the last message; None if there are none."""
        # Empty chunks have their end before their beginning.
        pieces = [one for one in self._index.pieces if one.start_ns <= one.end_ns]
        if not pieces:
            return None
        return min(one.start_ns for one in pieces), max(one.end_ns for one in pieces)

    def attachment(self, name: str) -> bytes:
        """The content of an attachment.

        Raises:
            KeyError: there is none of the name.
            RecordingError: it is damaged.
        """
        offset, length = self._index.attachments[name]
        with self._opened() as file:
            content = content_at(file, offset, length, Opcode.ATTACHMENT)
            content.bytes(16)
            content.text()
            content.text()
            return content.bytes(content.number(8))

    def messages(self, topics: Collection[str] | None, start_ns: int) -> Iterator[RecordedMessage]:
        """As ``RecordingReader.messages``."""
        wanted = {n: name for n, name in self._names.items() if topics is None or name[0] in topics}
        waiting: list[tuple[int, int, RecordedMessage]] = []
        count = 0
        with self._opened() as file:
            for piece in _pieces(self._index, wanted, start_ns):
                # Chunks may overlap: what is older than all of the next one can go out.
                while waiting and waiting[0][0] <= piece.start_ns:
                    yield heapq.heappop(waiting)[2]
                for message in _messages(file, piece, wanted):
                    if message.log_time_ns >= start_ns:
                        heapq.heappush(waiting, (message.log_time_ns, count, message))
                        count += 1
        while waiting:
            yield heapq.heappop(waiting)[2]

    @contextmanager
    def _opened(self) -> Iterator[BinaryIO]:
        try:
            with self.path.open("rb") as file:
                yield file
        except (OSError, ValueError) as error:
            if isinstance(error, RecordingError):
                raise
            if isinstance(error, DamageError):
                raise RecordingError(
                    f"{self.path} is damaged: {error}; valid is a whole MCAP file"
                ) from error
            why = getattr(error, "strerror", None) or error
            raise RecordingError(f"{self.path} cannot be read: {why}") from error


def _pieces(index: Index, wanted: Collection[int], start_ns: int) -> list[Piece]:
    """Those that may have wanted messages, by time."""
    found = [
        one
        for one in index.pieces
        if one.end_ns >= start_ns and (one.channels is None or not one.channels.isdisjoint(wanted))
    ]
    return sorted(found, key=lambda one: (one.start_ns, one.offset))


def _messages(
    file: BinaryIO, piece: Piece, wanted: dict[int, tuple[str, str]]
) -> Iterator[RecordedMessage]:
    """The wanted messages of a piece, as written."""
    if piece.chunk:
        content = content_at(file, piece.offset, piece.length, Opcode.CHUNK)
        data = records_of(ChunkHead.read(content))
    else:
        data = read_at(file, piece.offset, piece.length)
    for opcode, start, end in split(data):
        if opcode != Opcode.MESSAGE:
            continue
        if end - start < MESSAGE.size:
            raise DamageError("a message is cut off")
        channel, _, log_time_ns, _ = MESSAGE.unpack_from(data, start)
        if channel in wanted:
            topic, type_name = wanted[channel]
            yield RecordedMessage(topic, type_name, log_time_ns, data[start + MESSAGE.size : end])


def _check_beginning(path: Path, file: BinaryIO) -> None:
    """Refuse what is no MCAP file.

    Raises:
        RecordingError: says what it is.
    """
    begin = file.read(len(MAGIC) + HEAD.size)
    valid = "valid is an MCAP file with ROS 2 messages"
    if not begin:
        raise RecordingError(f"{path} is empty; {valid}")
    for beginning, what in OTHERS.items():
        if begin.startswith(beginning):
            raise RecordingError(f"{path} is {what}; {valid}")
    if not MAGIC.startswith(begin[: len(MAGIC)]):
        raise RecordingError(f"{path} is no MCAP file; {valid}")
    if len(begin) < len(MAGIC) + HEAD.size:
        raise RecordingError(f"{path} is an MCAP file that ends at once; {valid}")
    opcode, _ = HEAD.unpack_from(begin, len(MAGIC))
    if opcode != Opcode.HEADER:
        raise RecordingError(f"{path} is an MCAP file without its first record; {valid}")
