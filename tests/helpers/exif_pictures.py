"""Pictures that say by EXIF that they are to be turned."""

from __future__ import annotations

import zlib


def tiff_header(orientation: int, order: str = "II") -> bytes:
    """EXIF of one entry, in either order of bytes."""

    def whole(value: int, size: int) -> bytes:
        return value.to_bytes(size, "little" if order == "II" else "big")

    entry = whole(0x0112, 2) + whole(3, 2) + whole(1, 4) + whole(orientation, 2) + bytes(2)
    return order.encode() + whole(42, 2) + whole(8, 4) + whole(1, 2) + entry + bytes(4)


def with_exif(png: bytes, exif: bytes) -> bytes:
    """A PNG with another chunk after its header."""
    body = b"eXIf" + exif
    chunk = len(exif).to_bytes(4, "big") + body + zlib.crc32(body).to_bytes(4, "big")
    return png[:33] + chunk + png[33:]
