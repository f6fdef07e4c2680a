"""Index of an MCAP file, what it holds and where: from its summary, or from reading all of it.

An unfinished file (the program was killed, the disk was full) has no summary, and may end in the
middle of a record. All whole records are used, also those behind a damage.
"""

from __future__ import annotations

import zlib
from collections import Counter
from dataclasses import dataclass, field
from typing import BinaryIO, NamedTuple

from mcap import records
from mcap.opcode import Opcode
from mcap.reader import FOOTER_SIZE
from mcap.stream_reader import MAGIC_SIZE

from app.features.recordings.files.mcap_records import (
    CHANNELS,
    HEAD,
    DamageError,
    is_opcode,
    messages_of,
    place_behind,
    read_at,
    record_of,
    records_of,
    require_own_length,
    size_of,
)

RUN = 1 << 20
"""Approximate length of the runs in which messages outside of chunks are read [bytes]."""


class Piece(NamedTuple):
    """Messages that lie together: a chunk, or a run of messages outside of chunks."""

    start_ns: int
    offset: int
    """Position in the file [bytes]."""
    length: int
    end_ns: int
    channels: frozenset[int]
    """The channels that have messages in it; empty if they are not known."""
    loose: bool = False
    """Whether it is a run outside of chunks."""


@dataclass(slots=True)
class Damage:
    """A place in a file where messages may be missing."""

    start_ns: int | None
    """Log time of the last message before it; None if there is none."""
    end_ns: int | None = None
    """Log time of the first message after it; None if there is none."""


@dataclass(slots=True)
class Index:
    """What a file holds."""

    schemas: dict[int, records.Schema] = field(default_factory=dict)
    channels: dict[int, records.Channel] = field(default_factory=dict)
    pieces: list[Piece] = field(default_factory=list)
    attachments: dict[str, tuple[int, int]] = field(default_factory=dict)
    """Offset and length of their records."""
    metadata: dict[str, dict[str, str]] = field(default_factory=dict)
    complete: bool = False
    """Whether the file was finished."""
    counts: Counter[int] = field(default_factory=Counter)
    """Number of messages by channel."""
    damages: list[Damage] = field(default_factory=list)
    """Damages that reading all of the file has met, in the order of the file."""

    def take(self, record: records.McapRecord) -> None:
        """Add the content of a record."""
        match record:
            case records.Schema():
                self.schemas[record.id] = record
            case records.Channel():
                self.channels[record.id] = record
            case records.Metadata(name=name) if name == CHANNELS:
                self._take_channels(record.metadata)
            case records.Metadata():
                self.metadata[record.name] = record.metadata
            case records.Statistics():
                self.counts.update(record.channel_message_counts)
            case records.AttachmentIndex():
                self.attachments[record.name] = (record.offset, record.length)

    def _take_channels(self, repeated: dict[str, str]) -> None:
        """Add the channels whose own records were in a chunk that is damaged."""
        for number, words in repeated.items():
            topic, _, type_name = words.partition(" ")
            if number.isdecimal() and int(number) not in self.channels:
                # Its schema's number is not known; numbers in files are positive.
                schema = records.Schema(id=-int(number), name=type_name, encoding="", data=b"")
                channel = records.Channel(
                    id=int(number), topic=topic, message_encoding="cdr", metadata={},
                    schema_id=schema.id,
                )  # fmt: skip
                self.schemas[schema.id], self.channels[channel.id] = schema, channel

    def miss(self) -> None:
        """Take note of a damage; several without a piece between them count as one."""
        if not self.damages or self.damages[-1].end_ns is not None:
            before = max((piece.end_ns for piece in self.pieces), default=None)
            self.damages.append(Damage(before))

    def add(self, piece: Piece) -> None:
        """Append a piece; adjacent runs outside of chunks are joined, up to about ``RUN`` bytes."""
        if self.damages and self.damages[-1].end_ns is None:
            self.damages[-1].end_ns = piece.start_ns
        last = self.pieces[-1] if self.pieces else piece
        ends = last.offset + last.length
        if last.loose and piece.loose and ends == piece.offset and last.length < RUN:
            start_ns, end_ns = min(last.start_ns, piece.start_ns), max(last.end_ns, piece.end_ns)
            length, channels = last.length + piece.length, last.channels | piece.channels
            self.pieces[-1] = Piece(start_ns, last.offset, length, end_ns, channels, loose=True)
        else:
            self.pieces.append(piece)


def index_of(file: BinaryIO) -> Index:
    """Return the index of a file whose beginning has been checked."""
    try:
        return _from_summary(file)
    except DamageError:
        return _from_all(file)


def _from_summary(file: BinaryIO) -> Index:
    index = Index(complete=True)
    for record in records_of(_summary(file), end=b""):
        match record:
            case records.ChunkIndex(message_start_time=start_ns, message_end_time=end_ns):
                channels = frozenset(record.message_index_offsets)
                place = record.chunk_start_offset, record.chunk_length
                index.add(Piece(start_ns, *place, end_ns, channels))
            case records.MetadataIndex():
                data = read_at(file, record.offset, record.length)
                index.take(record_of(data, records.Metadata))
            case _:
                index.take(record)
    if index.counts and not index.pieces:
        raise DamageError("the summary has no chunks")
    if any(channel.schema_id not in (0, *index.schemas) for channel in index.channels.values()):
        raise DamageError("the summary has not all schemas")
    if any(not piece.channels <= index.channels.keys() for piece in index.pieces):
        raise DamageError("the summary has not all channels")
    return index


def _summary(file: BinaryIO) -> bytes:
    """Read the bytes from the first record of the summary to the file's end."""
    size, tail = size_of(file), FOOTER_SIZE + MAGIC_SIZE
    if size < 2 * tail:
        raise DamageError("the file is too short for a summary")
    footer = records_of(read_at(file, size - tail, tail), end=b"")[0]
    if not isinstance(footer, records.Footer) or not 0 < footer.summary_start <= size - tail:
        raise DamageError("there is no summary")
    data = read_at(file, footer.summary_start, size - footer.summary_start)
    # The checksum is the footer's last field (4 bytes).
    if footer.summary_crc and zlib.crc32(data[: -MAGIC_SIZE - 4]) != footer.summary_crc:
        raise DamageError("the summary's checksum is another")
    return data


def _from_all(file: BinaryIO) -> Index:
    """Index the file by reading it to its end; damaged parts are left out."""
    index, size = Index(), size_of(file)
    offset: int | None = MAGIC_SIZE
    while not index.complete and offset is not None and offset != size:
        begin = offset
        try:
            opcode, length = HEAD.unpack(read_at(file, begin, HEAD.size))
            _take(index, file, opcode, begin, HEAD.size + length)
            offset = begin + HEAD.size + length
        except DamageError:
            index.miss()
            offset = place_behind(file, begin)
    return index


def _take(index: Index, file: BinaryIO, opcode: int, offset: int, length: int) -> None:
    match opcode:
        case Opcode.CHUNK | Opcode.MESSAGE:
            data = read_at(file, offset, length)
            if opcode == Opcode.CHUNK:
                require_own_length(data)
            messages = messages_of(data, index.take)
            heads = [(channel, time_ns) for channel, time_ns, _ in messages]
            if heads:
                channels, times = zip(*heads, strict=True)
                index.counts.update(channels)
                loose, place = opcode == Opcode.MESSAGE, (offset, length)
                index.add(Piece(min(times), *place, max(times), frozenset(channels), loose))
        case Opcode.SCHEMA | Opcode.CHANNEL | Opcode.METADATA:
            index.take(record_of(read_at(file, offset, length), records.McapRecord))
        case Opcode.ATTACHMENT:
            # Only the name is parsed: damage to an attachment must not end the recording.
            data = read_at(file, offset, length)[HEAD.size + 16 :]
            name = data[4 : 4 + int.from_bytes(data[:4], "little")].decode(errors="replace")
            index.attachments[name] = (offset, length)
        case Opcode.DATA_END:
            index.complete = True
        case _ if not is_opcode(opcode):
            raise DamageError("there is no record")
