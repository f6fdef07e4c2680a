"""What an MCAP file holds and where: from its summary, or by going through all of it.

A file that was not finished (the program was killed, the disk was full) has no summary, and may end
in the middle of a record; all that is whole before is used.
"""

from __future__ import annotations

import io
import os
import zlib
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import BinaryIO

from app.recordings.files.chunks import records_of
from app.recordings.files.mcap_records import (
    FIRST_PRIVATE_OPCODE,
    FOOTER,
    HEAD,
    LAST_OPCODE,
    MAGIC,
    MESSAGE,
    Channel,
    ChunkHead,
    Content,
    DamageError,
    Opcode,
    Schema,
    split,
)

RUN = 1 << 20
"""Messages outside of chunks are read in runs of about so many bytes."""


@dataclass(frozen=True, slots=True)
class Piece:
    """Some messages that lie together: a chunk, or a run of messages outside of chunks."""

    offset: int
    """In the file [bytes]."""
    length: int
    start_ns: int
    end_ns: int
    chunk: bool
    channels: frozenset[int] | None
    """Those with messages in it; None if that is not known."""


@dataclass(slots=True)
class Index:
    """What a file holds."""

    schemas: dict[int, Schema] = field(default_factory=dict)
    channels: dict[int, Channel] = field(default_factory=dict)
    pieces: list[Piece] = field(default_factory=list)
    attachments: dict[str, tuple[int, int]] = field(default_factory=dict)
    """Offset and length of their records."""
    metadata: dict[str, dict[str, str]] = field(default_factory=dict)
    finished: bool = False
    damage: str = ""
    """What is wrong where the readable part ends; empty if it ends with a whole record."""


def index_of(file: BinaryIO) -> Index:
    """What a file holds; its beginning has been checked.

    Raises:
        DamageError: not even the first record is whole.
    """
    try:
        return _from_summary(file)
    except DamageError:
        return _Scan(file).index


def read_at(file: BinaryIO, offset: int, length: int) -> bytes:
    """Bytes of a file.

    Raises:
        DamageError: it ends before.
    """
    # A length that is damaged must not be asked for: memory is set aside for it first.
    if offset + length > os.fstat(file.fileno()).st_size:
        raise DamageError("the file ends in the middle of a record")
    file.seek(offset)
    data = file.read(length)
    if len(data) < length:
        raise DamageError("the file ends in the middle of a record")
    return data


def content_at(file: BinaryIO, offset: int, length: int, opcode: Opcode) -> Content:
    """The content of a record of a certain kind, which has a length with its head.

    Raises:
        DamageError: there is none.
    """
    if length < HEAD.size:
        raise DamageError("a record is cut off")
    data = read_at(file, offset, length)
    if HEAD.unpack_from(data) != (opcode, length - HEAD.size):
        raise DamageError(f"there is no {opcode.name} where the index says")
    return Content(data[HEAD.size :])


def _from_summary(file: BinaryIO) -> Index:
    data = _summary(file)
    index = Index(finished=True)
    messages = 0
    for opcode, start, end in split(data):
        content = Content(data[start:end])
        if opcode == Opcode.STATISTICS:
            messages = content.number(8)
        else:
            _take_summary(index, file, opcode, content)
    if messages and not index.pieces:
        raise DamageError("the summary has no chunks")
    if any(channel.schema not in (0, *index.schemas) for channel in index.channels.values()):
        raise DamageError("the summary has not all schemas")
    if any(not (one.channels or set()) <= index.channels.keys() for one in index.pieces):
        raise DamageError("the summary has not all channels")
    return index


def _summary(file: BinaryIO) -> bytes:
    size = file.seek(0, io.SEEK_END)
    tail = HEAD.size + 20 + len(MAGIC)
    if size < 2 * tail:
        raise DamageError("the file is too short for a summary")
    footer = read_at(file, size - tail, tail)
    opcode, length, start, _, crc = FOOTER.unpack_from(footer)
    if footer[-len(MAGIC) :] != MAGIC or (opcode, length) != (Opcode.FOOTER, 20) or not start:
        raise DamageError("there is no summary")
    if not len(MAGIC) <= start <= size - tail:
        raise DamageError("the summary is elsewhere")
    data = read_at(file, start, size - tail - start)
    if crc and zlib.crc32(data + footer[: FOOTER.size - 4]) != crc:
        raise DamageError("the summary's checksum is another")
    return data


def _take_summary(index: Index, file: BinaryIO, opcode: int, content: Content) -> None:
    match opcode:
        case Opcode.SCHEMA | Opcode.CHANNEL:
            _take_definition(index, opcode, content)
        case Opcode.CHUNK_INDEX:
            start_ns, end_ns, offset, length = (content.number(8) for _ in range(4))
            channels = Content(content.bytes(content.number(4)))
            found = set()
            while channels.more:
                found.add(channels.number(2))
                channels.number(8)
            # A writer that keeps no index of messages tells no channels either.
            index.pieces.append(
                Piece(offset, length, start_ns, end_ns, True, frozenset(found) or None)
            )
        case Opcode.ATTACHMENT_INDEX:
            offset, length = content.number(8), content.number(8)
            content.bytes(24)
            index.attachments[content.text()] = (offset, length)
        case Opcode.METADATA_INDEX:
            offset, length = content.number(8), content.number(8)
            record = content_at(file, offset, length, Opcode.METADATA)
            _take_metadata(index, record)


def _take_definition(index: Index, opcode: int, content: Content) -> None:
    if opcode == Opcode.SCHEMA:
        number, schema = Schema.read(content)
        index.schemas[number] = schema
    else:
        number, channel = Channel.read(content)
        index.channels[number] = channel


def _take_metadata(index: Index, content: Content) -> None:
    name = content.text()
    index.metadata[name] = content.table()


class _Scan:
    """Goes through a file from its beginning to its end, or to the first damage."""

    def __init__(self, file: BinaryIO) -> None:
        self.index = Index()
        self._file = file
        self._run: list[tuple[int, int, int, int]] = []
        self._takers: dict[int, Callable[[int, int, Content], None]] = {
            Opcode.CHUNK: self._chunk,
            Opcode.MESSAGE: self._message,
            Opcode.SCHEMA: lambda *record: _take_definition(self.index, Opcode.SCHEMA, record[2]),
            Opcode.CHANNEL: lambda *record: _take_definition(self.index, Opcode.CHANNEL, record[2]),
            Opcode.ATTACHMENT: self._attachment,
            Opcode.METADATA: lambda *record: _take_metadata(self.index, record[2]),
        }
        self._go()

    def _go(self) -> None:
        offset, size = len(MAGIC), self._file.seek(0, io.SEEK_END)
        try:
            while not self.index.finished and offset != size:
                offset = self._record(offset)
        except DamageError as error:
            self.index.damage = f"{error}, at byte {offset}"
        self._end_run()

    def _record(self, offset: int) -> int:
        """Take the record at an offset; the next one's offset."""
        opcode, length = HEAD.unpack(read_at(self._file, offset, HEAD.size))
        if not (0 < opcode <= LAST_OPCODE or opcode >= FIRST_PRIVATE_OPCODE):
            raise DamageError("there is no record")
        if opcode != Opcode.MESSAGE and self._run:
            self._end_run()
        begin = offset + HEAD.size
        if opcode in self._takers:
            content = Content(read_at(self._file, begin, length))
            self._takers[opcode](offset, HEAD.size + length, content)
        self.index.finished = opcode == Opcode.DATA_END
        return int(begin + length)

    def _chunk(self, offset: int, length: int, content: Content) -> None:
        data = records_of(ChunkHead.read(content))
        times, channels = [], set()
        for opcode, start, end in split(data):
            if opcode == Opcode.MESSAGE:
                channel, time_ns = _head_of(data, start, end)
                channels.add(channel)
                times.append(time_ns)
            elif opcode in (Opcode.SCHEMA, Opcode.CHANNEL):
                _take_definition(self.index, opcode, Content(data[start:end]))
        if times:
            start_ns, end_ns = min(times), max(times)
            self.index.pieces.append(
                Piece(offset, length, start_ns, end_ns, True, frozenset(channels))
            )

    def _message(self, offset: int, length: int, content: Content) -> None:
        data = content.bytes(length - HEAD.size)
        self._run.append((offset, length, *_head_of(data, 0, len(data))))
        if offset - self._run[0][0] > RUN:
            self._end_run()

    def _end_run(self) -> None:
        if self._run:
            offset, (last, length) = self._run[0][0], self._run[-1][:2]
            times = [one[3] for one in self._run]
            channels = frozenset(one[2] for one in self._run)
            self.index.pieces.append(
                Piece(offset, last + length - offset, min(times), max(times), False, channels)
            )
            self._run.clear()

    def _attachment(self, offset: int, length: int, content: Content) -> None:
        content.bytes(16)
        self.index.attachments[content.text()] = (offset, length)


def _head_of(data: bytes, start: int, end: int) -> tuple[int, int]:
    """Channel and log time of a message's content."""
    if end - start < MESSAGE.size:
        raise DamageError("a message is cut off")
    channel, _, log_time_ns, _ = MESSAGE.unpack_from(data, start)
    return channel, log_time_ns
