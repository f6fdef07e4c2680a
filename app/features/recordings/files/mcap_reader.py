"""Reads recordings, finished or not: an MCAP file with ROS 2 messages, or a folder of such."""

from __future__ import annotations

import heapq
import zlib
from collections.abc import Collection, Iterable, Iterator, Mapping
from contextlib import contextmanager
from itertools import chain
from pathlib import Path
from typing import BinaryIO

from mcap.opcode import Opcode
from mcap.records import Attachment
from mcap.writer import MCAP0_MAGIC as MAGIC

from app.features.recordings.files.file_kinds import LONGEST, other_kind
from app.features.recordings.files.mcap_index import Damage, Piece, index_of
from app.features.recordings.files.mcap_records import (
    HEAD,
    DamageError,
    messages_of,
    read_at,
    record_of,
)
from app.features.recordings.files.recorded import CDR, RecordedMessage, RecordingError

NATURE = {"cdr": "ROS 2 messages in cdr", "ros1": "ROS 1 messages in ros1"}
"""Messages by their encoding, in words."""


def open_recording(path: Path, encodings: Collection[str] = (CDR,)) -> RecordingReader:
    """Open an MCAP file, or a folder with one or several files of the same recording.

    A ``metadata.yaml`` is not needed. Of an unfinished or damaged recording all whole chunks are
    read.

    Args:
        path: the file or folder.
        encodings: those of the messages that are wanted; all others are left out.

    Raises:
        RecordingError: the file does not exist, is something else, has no whole chunk, or has no
            messages in these encodings; says what it is and what is valid.
    """
    reader = RecordingReader(path, [McapFile(each, encodings) for each in _files(path)])
    if reader.damages and not any(file.pieces for file in reader.files):
        raise RecordingError(
            f"{path} is damaged: no message in it can be read; valid is a whole MCAP file"
        )
    if reader.damages and not reader.topics:
        raise RecordingError(
            f"{path} is damaged: what tells its topics stood in a part that cannot be read; valid "
            "is a whole MCAP file"
        )
    if not reader.topics:
        channels = [item for file in reader.files for item in file.index.channels.values()]
        others = {channel.message_encoding for channel in channels}.difference(encodings)
        holds = f"has messages in {', '.join(sorted(others))}" if others else "has no message"
        valid = " or ".join(NATURE[encoding] for encoding in encodings)
        raise RecordingError(f"{path} {holds}; valid are {valid}")
    return reader


class RecordingReader:
    """One recording; it keeps no file open, so several threads may read at the same time."""

    def __init__(self, path: Path, files: list[McapFile]) -> None:
        self.path = path
        self.files = files
        self.topics: dict[str, str] = {}
        """Types by topic, of all topics in a wanted encoding, with or without messages."""
        self.encodings: dict[str, str] = {}
        """Encodings by topic."""
        self.metadata: dict[str, dict[str, str]] = {}
        self.attachments: Mapping[str, bytes] = _Attachments(files)
        for file in files:
            self.topics |= dict(file.names.values())
            channels = file.index.channels
            self.encodings |= {
                name: channels[number].message_encoding for number, (name, _) in file.names.items()
            }
            self.metadata |= file.index.metadata
        # In an empty chunk, the end time is before the start time.
        pieces = [each for file in files for each in file.pieces if each.start_ns <= each.end_ns]
        self.start_ns = min((item.start_ns for item in pieces), default=0)
        """Log time of the first message."""
        self.end_ns = max((piece.end_ns for piece in pieces), default=0)
        self.unfinished = any(not file.index.complete for file in files)
        """Whether it was cut off: the program was killed, or the disk was full."""

    @property
    def duration(self) -> float:
        """From the first to the last message [s]."""
        return (self.end_ns - self.start_ns) / 1e9

    def count(self, topic: str) -> int | None:
        """Return the number of a topic's messages; None if the file does not say it."""
        counts = [file.index.counts for file in self.files]
        if not all(counts):
            return None
        return sum(
            file.index.counts[number]
            for file in self.files
            for number, (name, _) in file.names.items()
            if name == topic
        )

    @property
    def damages(self) -> list[str]:
        """Where messages are missing, in words, as far as was read until now."""
        return [self._words(damage) for file in self.files for damage in file.damages()]

    def damage_between(self, after_ns: int, until_ns: int) -> str | None:
        """Return in words what is missing before the messages of a span of log times [ns]."""
        for file in self.files:
            for damage in file.damages():
                if damage.end_ns is not None and after_ns < damage.end_ns <= until_ns:
                    return self._words(damage)
        return None

    def _words(self, damage: Damage) -> str:
        if damage.start_ns is None:
            return "the beginning is damaged" if damage.end_ns else "all of it is damaged"
        start = (damage.start_ns - self.start_ns) / 1e9
        if damage.end_ns is None:
            return f"what follows {start:.1f} s is damaged or cut off"
        missing = max(damage.end_ns - damage.start_ns, 0) / 1e9
        return f"{missing:.1f} s from {start:.1f} s on are damaged"

    def messages(
        self,
        topics: Collection[str] | None = None,
        start_ns: int = 0,
        *,
        as_written: bool = False,
    ) -> Iterator[RecordedMessage]:
        """Yield messages in the order of their log time; at the same time, as they were written.

        Damaged chunks are left out; ``damages`` then names them.

        Args:
            topics: only these, named as in ``topics``; None for all.
            start_ns: only those logged at this time or later [ns since 1970].
            as_written: in the files' own order instead, whatever the recorder's clock said.

        Raises:
            RecordingError: the file does not exist any more, or not one chunk can be read.
        """
        if as_written:
            return chain.from_iterable(file.as_written(topics, start_ns) for file in self.files)
        streams = [file.messages(topics, start_ns) for file in self.files]
        return heapq.merge(*streams, key=lambda item: item.log_time_ns)


class _Attachments(Mapping[str, bytes]):
    """Attachments by name, read at each access; raises RecordingError on damage."""

    def __init__(self, files: list[McapFile]) -> None:
        self._files = {name: file for file in files for name in file.index.attachments}

    def __getitem__(self, name: str) -> bytes:
        return self._files[name].attachment(name)

    def __contains__(self, name: object) -> bool:
        return name in self._files  # a damaged one is there, too

    def __iter__(self) -> Iterator[str]:
        return iter(self._files)

    def __len__(self) -> int:
        return len(self._files)


class McapFile:
    """One file of a recording; indexed by the constructor, and opened again for each read."""

    def __init__(self, path: Path, encodings: Collection[str] = (CDR,)) -> None:
        """Index the file; RecordingError if it is missing or not an MCAP file."""
        self.path = path
        with self._open() as file:
            _check_beginning(path, file)
            self.index = index_of(file)
        self.pieces = sorted(self.index.pieces, key=lambda item: (item.start_ns, item.offset))
        schemas = self.index.schemas
        self.names = {
            channel.id: (channel.topic, schemas[channel.schema_id].name)
            for channel in self.index.channels.values()
            if channel.message_encoding in encodings and channel.schema_id in schemas
        }
        """Topic and type by channel, of all channels in a wanted encoding."""
        self._damaged: set[int] = set()
        """Places in ``pieces`` of those that were met damaged."""

    def attachment(self, name: str) -> bytes:
        """The content of an attachment; RecordingError if it is damaged."""
        place = self.index.attachments[name]
        with self._open() as file:
            record = read_at(file, *place)
            result = record_of(record, Attachment)
            # The checksum is the record's last field (4 bytes), 0 if there is none.
            checksum = int.from_bytes(record[-4:], "little")
            if checksum and zlib.crc32(record[HEAD.size : -4]) != checksum:
                raise DamageError(f"the checksum of {name} is another")
        return result.data

    def damages(self) -> list[Damage]:
        """Where messages are missing, as far as was read until now."""
        result = list(self.index.damages)
        last = -2
        for place in sorted(self._damaged):
            piece = self.pieces[place]
            if place == last + 1:
                result[-1].end_ns = piece.end_ns
            else:
                result.append(Damage(piece.start_ns, piece.end_ns))
            last = place
        return result

    def messages(self, topics: Collection[str] | None, start_ns: int) -> Iterator[RecordedMessage]:
        """Yield messages as ``RecordingReader.messages`` does, by their log time."""
        queue: list[tuple[int, int, RecordedMessage]] = []
        count = 0
        for piece, messages in self._read(topics, start_ns, range(len(self.pieces))):
            # Chunks may overlap: only messages up to the start of the next one can go out.
            while queue and queue[0][0] <= piece.start_ns:
                yield heapq.heappop(queue)[2]
            for message in messages:
                heapq.heappush(queue, (message.log_time_ns, count, message))
                count += 1
        while queue:
            yield heapq.heappop(queue)[2]

    def as_written(
        self, topics: Collection[str] | None, start_ns: int
    ) -> Iterator[RecordedMessage]:
        """Yield messages in the order in which they are in the file."""
        places = sorted(range(len(self.pieces)), key=lambda place: self.pieces[place].offset)
        for _, messages in self._read(topics, start_ns, places):
            yield from messages

    def _read(
        self, topics: Collection[str] | None, start_ns: int, places: Iterable[int]
    ) -> Iterator[tuple[Piece, list[RecordedMessage]]]:
        """Yield pieces with their messages; those that are damaged are noted."""
        names = {n: name for n, name in self.names.items() if topics is None or name[0] in topics}
        with self._open() as file:
            for place in places:
                piece = self.pieces[place]
                # A file without an index of messages does not list the channels of a chunk either.
                channels = piece.channels or names.keys()
                if piece.end_ns < start_ns or channels.isdisjoint(names):
                    continue
                try:
                    held = list(messages_of(read_at(file, piece.offset, piece.length)))
                except DamageError:
                    self._damaged.add(place)
                    if len(self._damaged) == len(self.pieces):
                        raise
                    continue
                yield (
                    piece,
                    [
                        RecordedMessage(*names[channel], time_ns, cdr)
                        for channel, time_ns, cdr in held
                        if channel in names and time_ns >= start_ns
                    ],
                )

    @contextmanager
    def _open(self) -> Iterator[BinaryIO]:
        try:
            with self.path.open("rb") as file:
                yield file
        except RecordingError:
            raise
        except DamageError as error:
            raise RecordingError(
                f"{self.path} is damaged: {error}; valid is a whole MCAP file"
            ) from error
        except (OSError, ValueError) as error:
            why = getattr(error, "strerror", None) or error
            raise RecordingError(f"{self.path} cannot be read: {why}") from error


def _files(path: Path) -> list[Path]:
    try:
        if not path.is_dir():
            return [path]
        # Hidden files are what a Mac leaves beside those that it copies.
        result = sorted(item for item in path.glob("*.mcap") if item.name[0] != ".")
        others = sorted(item.name for item in path.iterdir())[:5]
    except (OSError, ValueError) as error:
        raise RecordingError(f"{path} cannot be read: {error}") from error
    if not result:
        holds = f"has {', '.join(others)}" if others else "is empty"
        raise RecordingError(f"{path} {holds}; valid is a folder with an .mcap file")
    return result


def _check_beginning(path: Path, file: BinaryIO) -> None:
    """Raise RecordingError if the file is not an MCAP file; it says what the file is."""
    begin = file.read(len(MAGIC) + HEAD.size)
    other = other_kind(begin + file.read(LONGEST))
    if not begin:
        description = "empty"
    elif other:
        description = other
    elif not MAGIC.startswith(begin[: len(MAGIC)]):
        description = "no MCAP file"
    elif len(begin) < len(MAGIC) + HEAD.size:
        description = "an MCAP file that ends at once"
    elif begin[len(MAGIC)] != Opcode.HEADER:
        description = "an MCAP file without its first record"
    else:
        return
    raise RecordingError(f"{path} is {description}; valid is an MCAP file with ROS 2 messages")
