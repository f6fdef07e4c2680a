"""A chunk's records, decompressed and checked."""

from __future__ import annotations

import zlib

import lz4.frame  # type: ignore[import-untyped]
import zstandard

from app.recordings.files.mcap_records import ChunkHead, DamageError

LARGEST_CHUNK = 1 << 29
"""A larger chunk is refused [bytes]: it has to fit into the memory of a small computer."""


def records_of(chunk: ChunkHead) -> bytes:
    """The records of a chunk.

    Raises:
        DamageError: it is damaged, too large, or compressed in an unknown way.
    """
    if chunk.size > LARGEST_CHUNK:
        raise DamageError(f"a chunk of {chunk.size} bytes is too large; valid are {LARGEST_CHUNK}")
    data = _decompressed(chunk)
    if len(data) != chunk.size:
        raise DamageError(f"a chunk has {len(data)} bytes instead of {chunk.size}")
    if chunk.crc and zlib.crc32(data) != chunk.crc:
        raise DamageError("a chunk's checksum is another")
    return data


def _decompressed(chunk: ChunkHead) -> bytes:
    match chunk.compression:
        case "":
            return chunk.stored
        case "zstd":
            return _zstd(chunk)
        case "lz4":
            return _lz4(chunk)
    raise DamageError(
        f"a chunk is compressed by {chunk.compression!r}; valid are zstd, lz4 and none"
    )


def _zstd(chunk: ChunkHead) -> bytes:
    try:
        # The frame's own word on its size is taken for memory before anything is decompressed.
        if zstandard.frame_content_size(chunk.stored) > chunk.size:
            raise DamageError("a chunk is larger than it says")
        return zstandard.decompress(chunk.stored, max_output_size=chunk.size)
    except zstandard.ZstdError as error:
        raise DamageError(f"a chunk cannot be decompressed: {error}") from error


def _lz4(chunk: ChunkHead) -> bytes:
    try:
        return bytes(
            lz4.frame.LZ4FrameDecompressor().decompress(chunk.stored, max_length=chunk.size)
        )
    except (RuntimeError, EOFError, ValueError) as error:
        raise DamageError(f"a chunk cannot be decompressed: {error}") from error
