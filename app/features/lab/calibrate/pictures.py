"""Pictures of a board in files: found, or refused with the reason."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import cv2
from tqdm import tqdm

from robot.calibration.lens.board import Board
from robot.calibration.lens.board_search import find_board
from robot.calibration.lens.corner_check import bend_px
from robot.calibration.lens.sighting import Sighting, SightingError
from robot.cameras.camera import PictureError
from robot.cameras.picture_files import SUFFIXES, FilePicture, pictures_in, read_picture
from robot.settings import SettingError

SQUARES, SIZE, KIND = "10x7", 0.025, "chessboard"
"""The usual board."""
MARKERS = "marker", "dictionary"
TAGS = "apriltag_36h11"
"""The usual tags of a grid of them."""
SAME = 3.0
"""A board that fits a picture this many times worse than another is not the one."""
MOST_PIXELS = 60_000_000
"""Larger pictures are refused."""


@dataclass(frozen=True)
class BoardSightings:
    """A board in pictures, by their names."""

    board: Board
    seen: dict[str, Sighting] = field(repr=False)
    refused: dict[str, str] = field(repr=False)
    """Why the other pictures are of no use."""
    to_turn: tuple[str, ...] = ()
    """Those that say that they are to be turned, and are not."""


def board_of(given: dict[str, Any]) -> Board:
    """Take the options of a board out of those given.

    Raises:
        SettingError: says what is valid.
    """
    squares = given.pop("squares", SQUARES)
    match = re.fullmatch(r"(\d{1,3})x(\d{1,3})", squares)
    if match is None:
        raise SettingError(f"--squares is {squares!r}; valid is such as {SQUARES}")
    rest = {name: given.pop(name) for name in (*MARKERS, "spacing") if name in given}
    kind, size = given.pop("type", KIND), given.pop("size", SIZE)
    if kind == "aprilgrid":
        rest = {"dictionary": TAGS} | rest
    return Board(kind, int(match[1]), int(match[2]), size, **rest)


def picture_files(paths: Sequence[Path]) -> list[Path]:
    """Return the files of pictures among files and folders, in the order given.

    Raises:
        SettingError: there are none.
    """
    result: list[Path] = []
    for path in paths:
        if path.is_dir():
            result += pictures_in(path)
        else:
            result.append(path)
    if not result:
        listed = ", ".join(str(path) for path in paths)
        raise SettingError(
            f"{listed} has no pictures; valid are files that end in {', '.join(SUFFIXES)}"
        )
    return result


def find_in(files: Sequence[Path], board: Board) -> BoardSightings:
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
    return BoardSightings(by_corners, {}, reasons)


def _misfit(some: BoardSightings) -> float:
    """Return how little the corners of a single picture look like those of a flat board [px]."""
    sighting = next(iter(some.seen.values()))
    return bend_px(some.board.corners[sighting.ids, :2], sighting.pixels)


def read_grey(path: Path) -> FilePicture:
    """Read a grey picture (h, w) as the camera gave it.

    Raises:
        SightingError: it is no picture.
    """
    try:
        picture = read_picture(path, cv2.IMREAD_GRAYSCALE)
    except PictureError as error:
        # The pictures are listed by their names, so the reason is enough.
        raise SightingError(str(error).removeprefix(f"{path} ").removeprefix("is ")) from error
    grey = picture.pixels
    if min(grey.shape) < 32 or grey.size > MOST_PIXELS:
        height, width = grey.shape
        raise SightingError(f"of {width} x {height} px; valid is 32 px to {MOST_PIXELS} pixels")
    return picture


def _find(named: Mapping[str, Path], board: Board) -> BoardSightings:
    seen: dict[str, Sighting] = {}
    refused: dict[str, str] = {}
    to_turn: list[str] = []
    alone = len(named) == 1
    for name, path in tqdm(named.items(), unit="picture", disable=alone or None):
        try:
            picture = read_grey(path)
            if picture.asks_to_be_turned:
                to_turn.append(name)
            seen[name] = find_board(picture.pixels, board)
        except SightingError as error:
            refused[name] = str(error)
    return BoardSightings(board, seen, refused, tuple(to_turn))


def _named(files: Sequence[Path]) -> dict[str, Path]:
    """Return files by the shortest names that tell them apart."""
    alone = len({path.name for path in files}) == len(files)
    return {path.name if alone else str(path): path for path in files}
