"""Lays out a printed board on a page, at its true size, with rulers to check the printer by."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import cv2
import numpy as np

from robot.calibration.lens.board import Board
from robot.geometry import Array
from robot.settings import SettingError

PAPERS = {"a4": (210.0, 297.0), "a3": (297.0, 420.0), "letter": (215.9, 279.4)}
"""Width and height of the papers, upright [mm]."""
BESIDE, ABOVE, BELOW = 18.0, 9.0, 25.0
"""Least white around the board [mm]: printers do not print to the edge, and rulers need room."""
RULER = 100.0
"""Length of the rulers [mm]."""
LINE = 0.3
"""Width of thin lines [mm]."""


@dataclass(frozen=True, slots=True, eq=False)
class FilledPolygon:
    """A filled polygon."""

    points: Array
    """(n, 2) right and down from the page's upper left corner [mm]."""
    black: bool = True


@dataclass(frozen=True, slots=True)
class Text:
    """A line of text."""

    x: float
    """Where it begins, right of the page's left side [mm]."""
    y: float
    """Its base line, below the page's top [mm]."""
    size: float
    """[mm]"""
    words: str


@dataclass(frozen=True)
class PrintedPage:
    """What is printed."""

    width: float
    """[mm]"""
    height: float
    """[mm]"""
    shapes: tuple[FilledPolygon, ...]
    """The first lie lowest."""
    texts: tuple[Text, ...]
    corner: tuple[float, float]
    """The board's upper left corner [mm]."""


def lay_out(board: Board, paper: str) -> PrintedPage:
    """Return the page of a board, upright or across.

    Raises:
        SettingError: there is no such paper, or the board is too large for it, or of tags.
    """
    if board.kind == "aprilgrid":
        raise SettingError("a grid of tags is not printed here; valid are chessboard and charuco")
    if paper not in PAPERS:
        raise SettingError(f"the paper is {paper!r}; valid are {', '.join(PAPERS)}")
    size = 1e3 * board.square
    wide, high = size * board.columns, size * board.rows
    short, long = PAPERS[paper]
    for width, height in ((short, long), (long, short)):
        if wide + 2 * BESIDE <= width and high + ABOVE + BELOW <= height:
            break
    else:
        raise SettingError(
            f"{board.columns} x {board.rows} squares of {size:g} mm are {wide:g} x {high:g} mm: "
            f"too large for {paper} ({short:g} x {long:g} mm); valid are smaller squares, "
            "fewer, or larger paper"
        )
    left, top = (width - wide) / 2, ABOVE + (height - high - ABOVE - BELOW) / 2
    shapes = [*_squares(board, left, top), *_origin(left + wide, top + high)]
    under = top + high + 13
    shapes += [*_ruler(left, under, (1, 0)), *_ruler(left - 11, top + 1, (0, 1))]
    kind = "" if board.kind == "chessboard" else f" --type charuco --dictionary {board.dictionary}"
    option = "" if board.marker == Board.marker or not kind else f" --marker {board.marker:g}"
    words = f"{board.words}, {size:g} mm"
    texts = [
        Text(left + wide + 4.5, top + high - 13, 3.2, "x"),
        Text(left + wide - 14, top + high + 6.5, 3.2, "y"),
        Text(left + RULER + 4, under + 1, 2.6, "Both rulers must be 100 mm: print at 100 %."),
        Text(left, under + 6, 2.6, words[:1].upper() + words[1:]),
        Text(left, under + 9.5, 2.6, f"brickpose calibrate lens PICTURES{kind} --squares "
             f"{board.columns}x{board.rows} --size {board.square:g}{option}"),
    ]  # fmt: skip
    return PrintedPage(width, height, tuple(shapes), tuple(texts), (left, top))


def _squares(board: Board, left: float, top: float) -> Iterator[FilledPolygon]:
    size = 1e3 * board.square
    for row in range(board.rows):
        for column in range(board.columns):
            if (row + column) % 2 == 0:
                yield _box(left + column * size, top + row * size, size, size)
    if board.kind == "charuco":
        yield from _markers(board, left, top)


def _markers(board: Board, left: float, top: float) -> Iterator[FilledPolygon]:
    """Yield the markers in the white squares: each a black box, and what is white in it."""
    drawing = board.markers
    dictionary = drawing.getDictionary()
    modules = dictionary.markerSize + 2
    for corners, number in zip(
        drawing.getObjPoints(), np.ravel(np.asarray(drawing.getIds())), strict=True
    ):
        x, y = (1e3 * np.asarray(corners)[0, :2] + (left, top)).tolist()
        side = 1e3 * board.square * board.marker
        cell = side / modules
        yield _box(x, y, side, side)
        bits = np.asarray(cv2.aruco.generateImageMarker(dictionary, int(number), modules)) > 0
        for row, line in enumerate(bits):
            edges = np.flatnonzero(np.diff(np.concatenate([[0], line.astype(int), [0]])))
            for start, end in edges.reshape(-1, 2).tolist():
                box = _box(x + start * cell, y + row * cell, (end - start) * cell, cell)
                yield FilledPolygon(box.points, black=False)


def _origin(x: float, y: float) -> Iterator[FilledPolygon]:
    """Yield arrows along the axes of the board's frame, and marks at its lower right corner."""
    reach, apart = 10.0, 3.0
    yield _box(x + 0.8, y - LINE / 2, 6, LINE)
    yield _box(x - LINE / 2, y + 0.8, LINE, 6)
    yield _box(x + apart - LINE / 2, y - reach, LINE, reach)
    yield _box(x - reach, y + apart - LINE / 2, reach, LINE)
    for tip in ((x + apart, y - reach - 2.5), (x - reach - 2.5, y + apart)):
        along = np.array([0, 2.5]) if tip[1] < y else np.array([2.5, 0])
        base = np.array(tip) + along
        yield FilledPolygon(np.array([tip, base + along[::-1] / 2.5, base - along[::-1] / 2.5]))


def _ruler(x: float, y: float, along: tuple[int, int]) -> Iterator[FilledPolygon]:
    """Yield a ruler; its outer ticks' outer sides are ``RULER`` apart."""
    dx, dy = along
    yield _box(x, y, RULER if dx else LINE, RULER if dy else LINE)
    for mark in range(0, round(RULER) + 1, 5):
        place = float(np.clip(mark - LINE / 2, 0, RULER - LINE))
        long = 4.0 if mark % 50 == 0 else 2.5 if mark % 10 == 0 else 1.5
        yield _box(x + dx * place - dy * long, y + dy * place - dx * long,
                   LINE if dx else long, LINE if dy else long)  # fmt: skip


def _box(x: float, y: float, width: float, height: float) -> FilledPolygon:
    return FilledPolygon(
        np.array([[x, y], [x + width, y], [x + width, y + height], [x, y + height]])
    )
