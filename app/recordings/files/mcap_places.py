"""Places in an MCAP file that may be damaged: reads bytes, and finds the next record to go on."""

from __future__ import annotations

import os
import re
import struct
from collections.abc import Iterator
from itertools import islice
from typing import BinaryIO

from mcap.opcode import Opcode
from mcap.records import Metadata

from app.recordings.files.mcap_records import (
    HEAD,
    LARGEST_CHUNK,
    DamageError,
    messages_of,
    record_of,
)

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
"""So much of the file is searched at a time [bytes]."""

MOST_TRIED = 1000
"""So many places that look like a chunk are tried: in a hostile file all look so."""


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

    That is where the record ends by its length, if another record begins there. Otherwise the
    length is damaged, too, and it is the next whole chunk, or the metadata with the channels.
    """
    try:
        _, length = HEAD.unpack(read_at(file, begin, HEAD.size))
        end: int = begin + HEAD.size + length
        if end == size_of(file):
            return end
        opcode, length = HEAD.unpack(read_at(file, end, HEAD.size))
        if is_opcode(opcode) and end + HEAD.size + length <= size_of(file):
            return end
    except DamageError:
        pass
    tried = islice(_candidates(file, begin + 1), MOST_TRIED)
    return next((offset for offset in tried if _is_whole(file, offset)), None)


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
            place = match.start()
            if place >= BLOCK or place + seen > len(data):
                break
            _, length = HEAD.unpack_from(data, place)
            unpacked, _, letters, name = CHUNK_SIZES.unpack_from(data, place + first)
            named = (letters == 0) or (letters in (3, 4) and name in b"lz")
            fits = block + place + HEAD.size + length <= size_of(file)
            if fits and (data[place] == Opcode.METADATA or (named and unpacked <= LARGEST_CHUNK)):
                yield block + place
