"""The pictures of a folder with their stamps, in the order of time."""

from __future__ import annotations

import csv
import math
import re
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import cv2

from robot.cameras.picture_files import SUFFIXES, FilePicture, pictures_in, read_picture
from robot.errors import BrickPoseError
from robot.file_names import as_written

STAMP_NAMES = ("stamp", "timestamp", "time", "t")
"""Names of the column of stamps in a list with a header."""
PICTURE_NAMES = ("image", "picture", "file", "filename", "name")
"""Names of the column of file names."""
LARGEST_BYTES = 16 << 20
"""Largest list of stamps."""
TICKS = ((1e17, 1e9), (1e14, 1e6), (1e11, 1e3))
"""A whole number above the first counts this many parts of a second since 1970."""


class SequenceError(BrickPoseError, ValueError):
    """A folder of pictures that cannot be used; the message says what is valid."""


@dataclass(frozen=True, slots=True)
class StampedPicture:
    """One picture of a sequence."""

    stamp: float
    """[s]"""
    path: Path

    @property
    def name(self) -> str:
        """Name of the file."""
        return self.path.name

    def read(self) -> FilePicture:
        """Return the picture, BGR.

        Raises:
            PictureError: it cannot be read.
        """
        return read_picture(self.path, cv2.IMREAD_COLOR)


def is_folder_of_pictures(path: Path) -> bool:
    """Return whether a path is a folder with pictures in it, or with nothing that a bag has."""
    return path.is_dir() and not any(
        (item.name[0] != "." and item.suffix in (".bag", ".mcap", ".db3"))
        or item.name == "metadata.yaml"
        for item in path.iterdir()
    )


def read_sequence(folder: Path, stamps: Path | None = None) -> list[StampedPicture]:
    """Return the pictures of a folder by time.

    Args:
        stamps: a list of stamps and file names: CSV with a header that names a column of
            ``STAMP_NAMES`` and one of ``PICTURE_NAMES``, or lines ``stamp name`` as the TUM RGB-D
            benchmark has them. Without it, the names of the files are their stamps.

    Raises:
        SequenceError: there are no pictures, or a stamp is missing or there twice.
    """
    paths = pictures_in(folder)
    if not paths:
        raise SequenceError(
            f"{folder} has no pictures; valid are files that end in {', '.join(SUFFIXES)}"
        )
    if stamps is None:
        pictures = [StampedPicture(stamp_of_name(path), path) for path in paths]
    else:
        pictures = _listed(stamps, folder)
    pictures.sort(key=lambda picture: picture.stamp)
    for before, after in pairwise(pictures):
        if before.stamp == after.stamp:
            raise SequenceError(
                f"{before.name} and {after.name} have the same stamp {before.stamp:.6f} s; "
                "valid is one picture a stamp"
            )
    return pictures


def stamp_of_name(path: Path) -> float:
    """Return the stamp [s] that the name of a picture tells.

    Valid endings of a name are seconds with a point (``12.25``), seconds and nanoseconds
    (``1574103165_227621078``), and whole milli-, micro- or nanoseconds since 1970.

    Raises:
        SequenceError: the name tells none.
    """
    stem = path.stem
    if match := re.search(r"(?<!\d)(\d+\.\d+)$", stem):
        return float(match[1])
    # The nanoseconds may be written without their leading zeros.
    if match := re.search(r"(?<!\d)(\d{9,10})[_-](\d{1,9})$", stem):
        return float(match[1]) + int(match[2]) * 1e-9
    if match := re.search(r"(?<!\d)(\d{12,19})$", stem):
        ticks = int(match[1])
        for least, a_second in TICKS:
            if ticks >= least:
                return ticks / a_second
    raise SequenceError(
        f"{path.name} tells no stamp; valid are names that end in seconds (12.25), seconds and "
        "nanoseconds (1574103165_227621078) or whole milli-, micro- or nanoseconds since 1970, "
        "or a list (--stamps FILE)"
    )


def _listed(stamps: Path, folder: Path) -> list[StampedPicture]:
    try:
        if stamps.stat().st_size > LARGEST_BYTES:
            raise SequenceError(f"{stamps} is too large; valid are up to {LARGEST_BYTES} bytes")
        lines = stamps.read_text(encoding="utf-8-sig").splitlines()
    except OSError as error:
        raise SequenceError(f"{stamps} cannot be read: {error.strerror}") from error
    except UnicodeDecodeError as error:
        raise SequenceError(f"{stamps} is no text: {error}") from error
    rows = [
        (number, _words(line))
        for number, line in enumerate(lines, 1)
        if line.strip() and not line.lstrip().startswith("#")
    ]
    if not rows:
        raise SequenceError(f"{stamps} lists no picture; valid are lines: stamp name")
    columns = _columns(rows[0][1])
    if columns is None:
        columns = (0, 1)
    else:
        rows = rows[1:]
    return [_picture(words, columns, f"{stamps}:{number}", folder) for number, words in rows]


def _words(line: str) -> list[str]:
    words = next(csv.reader([line])) if "," in line else line.split()
    return [word.strip() for word in words]


def _columns(header: list[str]) -> tuple[int, int] | None:
    """Return the columns of stamp and name that a header names; None if it is no header."""
    names = [name.lower() for name in header]
    stamp = next((names.index(name) for name in STAMP_NAMES if name in names), None)
    picture = next((names.index(name) for name in PICTURE_NAMES if name in names), None)
    return None if stamp is None or picture is None else (stamp, picture)


def _picture(
    words: list[str], columns: tuple[int, int], where: str, folder: Path
) -> StampedPicture:
    if len(words) <= max(columns):
        raise SequenceError(f"{where}: a stamp and the name of a picture are due")
    text, name = words[columns[0]], words[columns[1]]
    try:
        stamp = float(text)
    except ValueError:
        stamp = math.nan
    if not math.isfinite(stamp):
        raise SequenceError(f"{where}: {text[:40]!r} is no stamp; valid is a number of seconds")
    path = folder / name
    if not path.is_file():
        # TUM's lists name the pictures from the folder above.
        path = folder / Path(name).name
    if not path.is_file():
        path = as_written(path)
    if not path.is_file():
        raise SequenceError(f"{where}: there is no picture {name[:80]!r} in {folder}")
    return StampedPicture(stamp, path)
