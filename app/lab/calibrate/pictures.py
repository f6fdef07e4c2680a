"""Pictures of a board in files: found, or refused with the reason."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from tqdm import tqdm

from robot.calibration.lens.board import Board
from robot.calibration.lens.corner_check import bend_px
from robot.calibration.lens.sighting import Grey, Sighting, SightingError, find_board
from robot.cameras.files import SUFFIXES
from robot.settings import SettingError

SQUARES, SIZE, KIND = "10x7", 0.025, "chessboard"
"""The usual board."""
SAME = 3.0
"""A board that fits a picture this many times worse than another is not the one."""
MOST_PIXELS = 60_000_000
"""Larger pictures are refused."""


@dataclass(frozen=True)
class Sightings:
    """A board in pictures, by their names."""

    board: Board
    seen: dict[str, Sighting] = field(repr=False)
    refused: dict[str, str] = field(repr=False)
    """Why the other pictures are of no use."""


def board_of(given: dict[str, Any]) -> Board:
    """Take the options of a board out of those given.

    Raises:
        SettingError: says what is valid.
    """
    squares = given.pop("squares", SQUARES)
    match = re.fullmatch(r"(\d{1,3})x(\d{1,3})", squares)
    if match is None:
        raise SettingError(f"--squares is {squares!r}; valid is such as {SQUARES}")
    rest = {name: given.pop(name) for name in ("marker", "dictionary") if name in given}
    kind, size = given.pop("type", KIND), given.pop("size", SIZE)
    return Board(kind, int(match[1]), int(match[2]), size, **rest)


def picture_files(paths: Sequence[Path]) -> list[Path]:
    """Return the files of pictures among files and folders, in the order given.

    Raises:
        SettingError: there are none.
    """
    result: list[Path] = []
    for path in paths:
        if path.is_dir():
            result += sorted(p for p in path.iterdir() if p.suffix.lower() in SUFFIXES)
        else:
            result.append(path)
    if not result:
        listed = ", ".join(str(path) for path in paths)
        raise SettingError(
            f"{listed} has no pictures; valid are files that end in {', '.join(SUFFIXES)}"
        )
    return result


def find_in(files: Sequence[Path], board: Board) -> Sightings:
    """Find a board in pictures.

    People count squares, or inner corners as ROS does: of a chessboard both are tried, until one of
    them is in a picture.
    """
    named = _named(files)
    if board.kind != "chessboard":
        return _find(named, board)
    by_corners = replace(board, columns=board.columns + 1, rows=board.rows + 1)
    reasons: dict[str, str] = {}
    for name, path in named.items():
        seen = [_find({name: path}, meant) for meant in (by_corners, board)]
        good = [some for some in seen if some.seen]
        if good:
            first, last = good[0], good[-1]
            clear = _misfit(first) < SAME * _misfit(last) + 1
            return _find(named, (first if clear else last).board)
        reasons |= seen[0].refused
    return Sightings(by_corners, {}, reasons)


def _misfit(some: Sightings) -> float:
    """Return how little the corners of a single picture look like those of a flat board [px]."""
    sighting = next(iter(some.seen.values()))
    return bend_px(some.board.corners[sighting.ids, :2], sighting.pixels)


def read_grey(path: Path) -> Grey:
    """Read a picture (h, w) as the camera gave it, not turned by what a file says besides.

    Raises:
        SightingError: it is no picture.
    """
    try:
        data = np.frombuffer(path.read_bytes(), np.uint8)
    except OSError as error:
        raise SightingError(f"cannot be read: {error.strerror}") from error
    flags = cv2.IMREAD_GRAYSCALE | cv2.IMREAD_IGNORE_ORIENTATION
    picture = cv2.imdecode(data, flags) if len(data) else None
    if picture is None:
        raise SightingError("no picture that can be read")
    if min(picture.shape) < 32 or picture.size > MOST_PIXELS:
        height, width = picture.shape
        raise SightingError(f"of {width} x {height} px; valid is 32 px to {MOST_PIXELS} pixels")
    return np.asarray(picture, np.uint8)


def _find(named: Mapping[str, Path], board: Board) -> Sightings:
    seen: dict[str, Sighting] = {}
    refused: dict[str, str] = {}
    alone = len(named) == 1
    for name, path in tqdm(named.items(), unit="picture", disable=alone or None):
        try:
            seen[name] = find_board(read_grey(path), board)
        except SightingError as error:
            refused[name] = str(error)
    return Sightings(board, seen, refused)


def _named(files: Sequence[Path]) -> dict[str, Path]:
    """Return files by the shortest names that tell them apart."""
    alone = len({path.name for path in files}) == len(files)
    return {path.name if alone else str(path): path for path in files}
