"""Pictures in files, as the camera gave them: nobody's wish to turn them is obeyed.

Phones and editors write into a file by how much it is to be turned when it is shown (EXIF's
orientation). A lens is calibrated for the pixels as they left the sensor, so a picture that was
turned would be of another camera.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

import cv2
import numpy as np

from robot.cameras.camera import Picture, PictureError

SUFFIXES = (".bmp", ".jpeg", ".jpg", ".pgm", ".png", ".ppm", ".tif", ".tiff", ".webp")
"""Endings of the files in a folder that count as pictures."""
AS_TAKEN = "pictures are taken as they left the sensor, in calibration, too"
TURNED = f"says by EXIF that it is to be turned; {AS_TAKEN}"
ORIENTATION = 0x0112
"""EXIF's and TIFF's tag."""
LONG = 4
"""The type of numbers of four bytes; orientations have two, but not all programs know that."""
BIG_TIFF = 43
"""In place of 42, what a TIFF with offsets of eight bytes has after its order of bytes."""


@dataclass(frozen=True, eq=False)
class FilePicture:
    """A picture of a file."""

    pixels: Picture = field(repr=False)
    """(h, w) or (h, w, 3) BGR, as they left the sensor."""
    asks_to_be_turned: bool
    """Whether programs that show it would turn or mirror it; ``TURNED`` says what was done."""


def pictures_in(folder: Path) -> list[Path]:
    """Return the pictures of a folder in the order of their names; of numbers, 2 is before 10.

    Hidden files are none: copies by macOS have one beside each picture, ``._1.jpg``, that holds no
    picture.
    """
    files = (path for path in folder.iterdir() if path.suffix.lower() in SUFFIXES)
    return sorted((path for path in files if path.name[0] != "."), key=_order)


def _order(path: Path) -> tuple[list[tuple[int, str]], str]:
    """Return what sorts names as people count: texts and numbers take turns."""
    parts = re.split(r"([0-9]+)", path.name)
    numbers = [int(part) if index % 2 else 0 for index, part in enumerate(parts)]
    texts = ["" if index % 2 else part for index, part in enumerate(parts)]
    return list(zip(numbers, texts, strict=True)), path.name


def read_picture(path: Path, flags: int = cv2.IMREAD_ANYCOLOR) -> FilePicture:
    """Read a picture.

    Args:
        flags: of OpenCV, on colours.

    Raises:
        PictureError: the file cannot be read, or is no picture.
    """
    try:
        data = bytearray(path.read_bytes())
    except OSError as error:
        raise PictureError(f"{path} cannot be read: {error.strerror}") from error
    tag = _orientation(data)
    turned = tag is not None and tag.value(data) in range(2, 9)
    if tag is not None and turned and _is_tiff(data):
        # OpenCV turns TIFF whatever it is told.
        data[tag.offset : tag.offset + tag.size] = (1).to_bytes(tag.size, tag.order)
    # Decoded from memory: OpenCV's reader of files writes its own complaints to the terminal.
    try:
        pixels = (
            cv2.imdecode(np.frombuffer(data, np.uint8), flags | cv2.IMREAD_IGNORE_ORIENTATION)
            if data
            else None
        )
    except cv2.error:
        pixels = None
    if pixels is None:
        raise PictureError(f"{path} is no picture that can be read; replace or remove it")
    return FilePicture(np.asarray(pixels, np.uint8), turned)


def turned_line(names: Sequence[str]) -> str:
    """Return what people should know of pictures that say that they are to be turned."""
    rest = f" (and {len(names) - 1} others)" if len(names) > 1 else ""
    return f"{names[0]}{rest} {TURNED}"


def _is_tiff(data: bytearray) -> bool:
    return data.startswith((b"II*\0", b"MM\0*", b"II+\0", b"MM\0+"))


@dataclass(frozen=True, slots=True)
class _Tag:
    """Where a whole number stands in a file."""

    offset: int
    size: int
    order: Literal["little", "big"]

    def value(self, data: bytearray) -> int:
        return int.from_bytes(data[self.offset : self.offset + self.size], self.order)


def _orientation(data: bytearray) -> _Tag | None:
    """Return where the orientation stands in a file; None if nowhere."""
    for start in _exif(data):
        order: Literal["little", "big"] = "little" if data[start : start + 1] == b"I" else "big"

        def number(offset: int, size: int, order: Literal["little", "big"] = order) -> int:
            return _Tag(offset, size, order).value(data)

        # A TIFF above 4 GB, or by programs that may write such, has wider numbers.
        wide = number(start + 2, 2) == BIG_TIFF
        table = start + (number(start + 8, 8) if wide else number(start + 4, 4))
        counted, length, value = (8, 20, 12) if wide else (2, 12, 8)
        for entry in range(min(number(table, counted), 512)):
            offset = table + counted + length * entry
            if number(offset, 2) == ORIENTATION and offset + length <= len(data):
                return _Tag(offset + value, 4 if number(offset + 2, 2) == LONG else 2, order)
    return None


def _exif(data: bytearray) -> Iterator[int]:
    """Return where EXIF begins in a picture of JPEG, PNG, WebP or TIFF."""
    if _is_tiff(data):
        return iter([0])
    if data[:2] == b"\xff\xd8":
        return _exif_of_jpeg(data)
    if data[:4] == b"\x89PNG":
        return _exif_of_png(data)
    if data[:4] == b"RIFF" and data[8:12] == b"WEBP":
        return _exif_of_webp(data)
    return iter([])


def _exif_of_jpeg(data: bytearray) -> Iterator[int]:
    offset = 2
    while data[offset : offset + 1] == b"\xff" and data[offset + 1 : offset + 2] != b"\xda":
        if data[offset + 1 : offset + 2] == b"\xff":  # any number of them may stand before a marker
            offset += 1
            continue
        if data[offset + 4 : offset + 10] == b"Exif\0\0":
            yield offset + 10
        offset += 2 + int.from_bytes(data[offset + 2 : offset + 4], "big")


def _exif_of_png(data: bytearray) -> Iterator[int]:
    offset = 8
    while offset + 8 <= len(data):
        if data[offset + 4 : offset + 8] == b"eXIf":
            yield offset + 8
        offset += 12 + int.from_bytes(data[offset : offset + 4], "big")


def _exif_of_webp(data: bytearray) -> Iterator[int]:
    offset = 12
    while offset + 8 <= len(data):
        size = int.from_bytes(data[offset + 4 : offset + 8], "little")
        if data[offset : offset + 4] == b"EXIF":
            yield offset + 8 + 6 * (data[offset + 8 : offset + 14] == b"Exif\0\0")
        offset += 8 + size + size % 2
