"""The records of an MCAP file, read from bytes that may be damaged (https://mcap.dev/spec).

A record is an opcode (1 byte), its length (8 bytes) and its content; numbers are little endian,
texts are UTF-8 after their length (4 bytes).
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from dataclasses import dataclass, field
from enum import IntEnum

MAGIC = b"\x89MCAP0\r\n"
HEAD = struct.Struct("<BQ")
FOOTER = struct.Struct("<BQQQI")
MESSAGE = struct.Struct("<HIQQ")
"""Channel, sequence, log time, publish time; the rest of the record is the message."""


class Opcode(IntEnum):
    """Kinds of records that matter here."""

    HEADER = 1
    FOOTER = 2
    SCHEMA = 3
    CHANNEL = 4
    MESSAGE = 5
    CHUNK = 6
    CHUNK_INDEX = 8
    ATTACHMENT = 9
    ATTACHMENT_INDEX = 10
    STATISTICS = 11
    METADATA = 12
    METADATA_INDEX = 13
    DATA_END = 15


LAST_OPCODE = 15
FIRST_PRIVATE_OPCODE = 0x80
"""From here on opcodes are a writer's own."""


class DamageError(ValueError):
    """Bytes that are no such record."""


class Content:
    """A record's content, read from its beginning; no length in it reaches beyond it."""

    def __init__(self, data: bytes) -> None:
        self._data = data
        self._place = 0

    def number(self, size: int) -> int:
        """An unsigned number of so many bytes."""
        return int.from_bytes(self.bytes(size), "little")

    def bytes(self, size: int) -> bytes:
        """So many bytes."""
        if size > len(self._data) - self._place:
            raise DamageError("a length reaches beyond its record")
        self._place += size
        return self._data[self._place - size : self._place]

    def text(self) -> str:
        """A text."""
        try:
            return self.bytes(self.number(4)).decode()
        except UnicodeDecodeError as error:
            raise DamageError("a text is no UTF-8") from error

    def table(self) -> dict[str, str]:
        """Texts by their names."""
        inner = Content(self.bytes(self.number(4)))
        found = {}
        while inner.more:
            name = inner.text()
            found[name] = inner.text()
        return found

    @property
    def more(self) -> bool:
        """Whether something is left."""
        return self._place < len(self._data)


@dataclass(frozen=True, slots=True)
class Schema:
    """The definition of a type."""

    name: str
    encoding: str
    text: bytes = field(repr=False)

    @classmethod
    def read(cls, content: Content) -> tuple[int, Schema]:
        """With its number."""
        number = content.number(2)
        name, encoding = content.text(), content.text()
        return number, cls(name, encoding, content.bytes(content.number(4)))


@dataclass(frozen=True, slots=True)
class Channel:
    """A topic."""

    schema: int
    topic: str
    encoding: str
    metadata: dict[str, str]

    @classmethod
    def read(cls, content: Content) -> tuple[int, Channel]:
        """With its number."""
        number, schema = content.number(2), content.number(2)
        return number, cls(schema, content.text(), content.text(), content.table())


@dataclass(frozen=True, slots=True)
class ChunkHead:
    """What stands before a chunk's records."""

    start_ns: int
    end_ns: int
    size: int
    """Of the records [bytes]."""
    crc: int
    """Of the records; 0 for none."""
    compression: str
    stored: bytes = field(repr=False)
    """The records, compressed."""

    @classmethod
    def read(cls, content: Content) -> ChunkHead:
        """From a chunk's content."""
        start_ns, end_ns, size = content.number(8), content.number(8), content.number(8)
        crc, compression = content.number(4), content.text()
        return cls(start_ns, end_ns, size, crc, compression, content.bytes(content.number(8)))


def split(data: bytes) -> Iterator[tuple[int, int, int]]:
    """Opcode, beginning and end of each record's content in the records of a chunk or summary.

    Raises:
        DamageError: the last one is cut off.
    """
    place, end = 0, len(data)
    while place < end:
        if end - place < HEAD.size:
            raise DamageError("a record is cut off")
        opcode, length = HEAD.unpack_from(data, place)
        place += HEAD.size
        if length > end - place:
            raise DamageError("a record is cut off")
        yield opcode, place, place + length
        place += length
