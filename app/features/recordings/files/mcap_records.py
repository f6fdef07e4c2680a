"""Reads the records of an MCAP file that may be damaged (https://mcap.dev/spec).

The mcap package reads their fields; this module checks what the package does not check. There are
many messages, so this module parses them without the package, in a tenth of the time. Behind a
damage it finds the next record to go on. All functions raise DamageError.
"""

from __future__ import annotations

import io
import os
import re
import struct
import zlib
from collections.abc import Callable, Iterator
from itertools import islice, takewhile
from typing import BinaryIO, TypeVar

import lz4.frame  # type: ignore[import-untyped]
import zstandard
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Chunk, Footer, McapRecord, Metadata
from mcap.stream_reader import StreamReader
from mcap.writer import MCAP0_MAGIC

from robot.errors import BrickPoseError

HEAD = struct.Struct("<BQ")
"""Head of each record: opcode, and length of the content."""
MESSAGE = struct.Struct("<HIQQ")
"""First fields of a message's record: channel, sequence, log time, publish time; the rest of the
record is the message."""

END = HEAD.pack(Opcode.FOOTER, 20) + bytes(20) + MCAP0_MAGIC
"""The end of a file, put behind data that are parsed: a record that claims to be longer than the
data runs into it, and is noticed."""

LARGEST_CHUNK = 1 << 29
"""Largest chunk [bytes]: it has to fit into the memory of a small computer."""

Record = TypeVar("Record", bound=McapRecord)
FIRST_PRIVATE_OPCODE = 0x80
"""Opcodes from here on are private to the writer."""
DATA_OPCODES = (
    Opcode.HEADER,
    Opcode.SCHEMA,
    Opcode.CHANNEL,
    Opcode.MESSAGE,
    Opcode.CHUNK,
    Opcode.MESSAGE_INDEX,
    Opcode.ATTACHMENT,
    Opcode.METADATA,
    Opcode.DATA_END,
)
CHANNELS = "channels"
"""Name of the metadata that repeat the channels outside of the chunks: topic and type by number."""
BEGIN = re.compile(rb"(?:\x06|\x0c(?=.{8}\x08\0{3}channels))(?=.{4}\0{4})", re.DOTALL)
"""How the record of a chunk begins that is shorter than 4 GiB, or that of those metadata."""
CHUNK_SIZES = struct.Struct("<QIIs")
"""In a chunk's record, after its times: size unpacked, checksum, length of the compression's name,
and that name's first letter."""
BLOCK = 1 << 22
"""How much of the file is searched at a time [bytes]."""
HEADS = 3
"""How many records have to follow where a damaged one ends by its length."""
MOST_TRIED = 1000
"""How many places that look like a chunk are tried: in a hostile file, all of them do."""


class DamageError(BrickPoseError, ValueError):
    """The bytes are not a valid record."""


def records_of(data: bytes, end: bytes = END) -> list[McapRecord]:
    """Parse records with their fields; the last one is a footer, and chunks are not unpacked.

    Args:
        end: the bytes to put behind the data; empty if the data reach to the file's end.
    """
    stream = io.BytesIO(data + end)
    try:
        return list(StreamReader(stream, skip_magic=True, emit_chunks=True).records)
    except (McapError, struct.error, OverflowError, UnicodeDecodeError) as error:
        why = str(error) or "it ends too early"
        raise DamageError(f"a record is damaged: {why}") from error


def record_of(data: bytes, kind: type[Record]) -> Record:
    """Parse bytes that are exactly one record, of a certain kind."""
    match records_of(data):
        case [record, Footer()] if isinstance(record, kind):
            return record
    raise DamageError(f"there is no {kind.__name__} where it should be")


def messages_of(
    data: bytes, take: Callable[[McapRecord], None] | None = None
) -> Iterator[tuple[int, int, bytes]]:
    """Yield channel, log time [ns] and content of messages in a chunk, or in a run outside chunks.

    Args:
        data: a chunk's record, or the messages' records.
        take: called with each schema and each channel.
    """
    if data[:1] != bytes([Opcode.MESSAGE]):
        data = _unpacked(record_of(data, Chunk))
    end = 0
    while end < len(data):
        begin, content = end, end + HEAD.size
        if content > len(data):
            raise DamageError("a record is cut off")
        opcode, length = HEAD.unpack_from(data, begin)
        body, end = content + MESSAGE.size, content + length
        if opcode == Opcode.MESSAGE and body <= end <= len(data):
            channel, _, log_time_ns, _ = MESSAGE.unpack_from(data, content)
            yield channel, log_time_ns, data[body:end]
        elif opcode == Opcode.MESSAGE or end > len(data):
            raise DamageError("a record is cut off")
        elif take and opcode in (Opcode.SCHEMA, Opcode.CHANNEL):
            take(record_of(data[begin:end], McapRecord))


def require_own_length(data: bytes) -> None:
    """Raise DamageError if a chunk's record does not end where its content does.

    Else a wrong length, whose chunk is whole, would swallow what follows.
    """
    name = HEAD.size + 16 + CHUNK_SIZES.size - 1
    letters = int.from_bytes(data[name - 4 : name], "little")
    content = name + letters + 8
    if content + int.from_bytes(data[content - 8 : content], "little") != len(data):
        raise DamageError("a chunk has another length than its content")


def _unpacked(chunk: Chunk) -> bytes:
    """The records of a chunk, decompressed and checked."""
    size = chunk.uncompressed_size
    if size > LARGEST_CHUNK:
        raise DamageError(f"a chunk of {size} bytes is too large; valid are {LARGEST_CHUNK}")
    try:
        data = _decompressed(chunk)
    except (zstandard.ZstdError, RuntimeError, EOFError) as error:
        raise DamageError(f"a chunk cannot be decompressed: {error}") from error
    if len(data) != size:
        raise DamageError(f"a chunk has {len(data)} bytes instead of {size}")
    if chunk.uncompressed_crc and zlib.crc32(data) != chunk.uncompressed_crc:
        raise DamageError("a chunk's checksum is another")
    return data


def _decompressed(chunk: Chunk) -> bytes:
    """Decompress at most the size that the chunk states: a few bytes may become gigabytes."""
    size = chunk.uncompressed_size
    match chunk.compression:
        case "":
            return chunk.data
        case "zstd":
            # The library allocates the size that the frame states before it decompresses anything.
            if zstandard.frame_content_size(chunk.data) > size:
                raise DamageError("a chunk is larger than it says")
            return zstandard.decompress(chunk.data, max_output_size=size)
        case "lz4":
            return bytes(lz4.frame.LZ4FrameDecompressor().decompress(chunk.data, max_length=size))
    raise DamageError(
        f"a chunk is compressed by {chunk.compression!r}; valid are zstd, lz4 and none"
    )


def size_of(file: BinaryIO) -> int:
    """Return the size of a file [bytes]."""
    return os.fstat(file.fileno()).st_size


def read_at(file: BinaryIO, offset: int, length: int) -> bytes:
    """Read bytes of a file; DamageError if the file ends before."""
    # Never read a damaged length: the memory for it would be allocated first.
    if offset + length <= size_of(file):
        file.seek(offset)
        data = file.read(length)
        if len(data) == length:
            return data
    raise DamageError("the file ends in the middle of a record")


def is_opcode(opcode: int) -> bool:
    """Whether a record of the data section may begin so."""
    return opcode in DATA_OPCODES or opcode >= FIRST_PRIVATE_OPCODE


def place_behind(file: BinaryIO, begin: int) -> int | None:
    """Return where to go on after a damaged record; None if nothing behind it can be read.

    That is the next whole chunk, or metadata with the channels, or where the record ends by its
    length if other records begin there. The length may be damaged, too.
    """
    try:
        _, length = HEAD.unpack(read_at(file, begin, HEAD.size))
        end: int = begin + HEAD.size + length
        by_length = _records_begin(file, end)
    except DamageError:
        by_length = False
    tried: Iterator[int] = islice(_candidates(file, begin + 1), MOST_TRIED)
    if by_length:
        tried = takewhile(lambda offset: offset < end, tried)
    whole = next((offset for offset in tried if _is_whole(file, offset)), None)
    return end if whole is None and by_length else whole


def _records_begin(file: BinaryIO, offset: int) -> bool:
    """Whether the heads of a few records follow each other; one alone may be chance."""
    for _ in range(HEADS):
        if offset == size_of(file):
            break
        opcode, length = HEAD.unpack(read_at(file, offset, HEAD.size))
        if opcode == Opcode.DATA_END:
            break
        offset += HEAD.size + length
        if not is_opcode(opcode) or offset > size_of(file):
            return False
    return True


def _is_whole(file: BinaryIO, offset: int) -> bool:
    """Whether whole metadata or a whole chunk begins at a place."""
    try:
        opcode, length = HEAD.unpack(read_at(file, offset, HEAD.size))
        data = read_at(file, offset, HEAD.size + length)
        if opcode == Opcode.METADATA:
            record_of(data, Metadata)
        else:
            for _ in messages_of(data):
                pass
    except DamageError:
        return False
    return True


def _candidates(file: BinaryIO, start: int) -> Iterator[int]:
    """Yield places where such a record may begin, of chunks by the sizes at their beginning."""
    first = HEAD.size + 16
    seen = first + CHUNK_SIZES.size
    for block in range(start, size_of(file), BLOCK):
        file.seek(block)
        data = file.read(BLOCK + seen)
        for match in BEGIN.finditer(data, 0, len(data)):
            offset = match.start()
            if offset >= BLOCK or offset + seen > len(data):
                break
            _, length = HEAD.unpack_from(data, offset)
            unpacked, _, letters, name = CHUNK_SIZES.unpack_from(data, offset + first)
            named = (letters == 0) or (letters in (3, 4) and name in b"lz")
            fits = block + offset + HEAD.size + length <= size_of(file)
            if fits and (data[offset] == Opcode.METADATA or (named and unpacked <= LARGEST_CHUNK)):
                yield block + offset
