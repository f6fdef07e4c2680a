"""Sheets that are glued cross on cross are the field at its true size."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass

import numpy as np
import pytest
import shapely
from shapely.affinity import translate

from app.features.field_editor.sheets import (
    PAPERS,
    Printing,
    SheetsError,
    laid_out,
    sheets_pdf,
)
from app.languages.catalogue import catalogue
from robot.geometry import Array

POINT = 25.4 / 72
"""[mm]"""
NEVER_MORE = 0.1
"""What a printed metre may be off [mm]."""
METRE = (
    '<svg xmlns="http://www.w3.org/2000/svg" width="1400mm" height="700mm" '
    'viewBox="-700 -350 1400 700"><rect x="-700" y="-350" width="1400" height="700" fill="#ddd"/>'
    '<path d="M -500 {y} h 1000" transform="rotate({turn})" stroke="black" stroke-width="50"/>'
    "</svg>"
)
NUMBER = r"(-?[\d.]+)"


@dataclass(frozen=True, eq=False)
class PrintedSheet:
    """What is on one sheet, in mm from the paper's lower left corner."""

    label: str
    paper: tuple[float, float]
    tape: shapely.Geometry
    crosses: Array


def printed(pdf: bytes) -> list[PrintedSheet]:
    """Read a PDF's sheets as a reader of PDF does: its operators, matrices and clips."""
    found = []
    boxes = re.findall(rb"/MediaBox \[0 0 ([\d.]+) ([\d.]+)\]", pdf)
    contents = re.findall(rb"stream\n(.*?)\nendstream", pdf, re.DOTALL)
    assert len(boxes) == len(contents)
    for box, content in list(zip(boxes, contents, strict=True))[1:]:
        text = content.decode("latin-1")
        label = re.search(r"sheet ([A-Z]+\d+)", text)
        assert label is not None
        clip = re.search(rf"q {NUMBER} {NUMBER} {NUMBER} {NUMBER} re W n", text)
        matrix = re.search(rf"{NUMBER} 0 0 {NUMBER} {NUMBER} {NUMBER} cm", text)
        assert clip is not None
        assert matrix is not None
        scale, also, x, y = map(float, matrix.groups())
        assert scale == also
        areas = []
        for path in re.findall(r"g (.*?) f\*", text):
            rings = []
            for ring in path.split("h"):
                places = re.findall(rf"{NUMBER} {NUMBER} [ml]", ring)
                if places:
                    rings.append((np.array(places, float) * scale + (x, y)) * POINT)
            areas.append(shapely.Polygon(rings[0], rings[1:]))
        left, low, width, height = (float(value) * POINT for value in clip.groups())
        window = shapely.box(left, low, left + width, low + height)
        found.append(
            PrintedSheet(
                label[1],
                (float(box[0]) * POINT, float(box[1]) * POINT),
                shapely.intersection(shapely.union_all(areas), window),
                crosses(text),
            )
        )
    return found


def crosses(text: str) -> Array:
    """Middles of crosses: of two lines in black, one after the other."""
    line = rf"{NUMBER} {NUMBER} m {NUMBER} {NUMBER} l S"
    pairs = re.findall(rf"0 G [\d.]+ w\n{line}\n{line}", text)
    ends = np.array(pairs, float).reshape(-1, 4, 2) * POINT
    assert np.allclose(ends[:, :2].mean(axis=1), ends[:, 2:].mean(axis=1))
    return ends.mean(axis=1).reshape(-1, 2)


def place_of(label: str) -> tuple[int, int]:
    letters, number = re.fullmatch(r"([A-Z]+)(\d+)", label).groups()  # type: ignore[union-attr]
    row = 0
    for letter in letters:
        row = row * 26 + ord(letter) - 64
    return row - 1, int(number) - 1


def glued(sheets: list[PrintedSheet]) -> dict[str, Array]:
    """Lay sheets cross on cross, one beside the other; return where each lies."""
    by_place = {place_of(sheet.label): sheet for sheet in sheets}
    first = min(by_place)
    where = {first: np.zeros(2)}
    waiting = [first]
    while waiting:
        row, column = waiting.pop()
        here = by_place[row, column]
        for step, axis in (((0, 1), 0), ((0, -1), 0), ((1, 0), 1), ((-1, 0), 1)):
            there = (row + step[0], column + step[1])
            if there not in by_place or there in where:
                continue
            ends = max if step in ((0, 1), (-1, 0)) else min
            mine = on_side(here.crosses, axis, ends)
            theirs = on_side(by_place[there].crosses, axis, min if ends is max else max)
            assert len(mine) == len(theirs) == 3
            offsets = mine - theirs
            assert np.ptp(offsets, axis=0).max() < 1e-3, "crosses lie on crosses"
            where[there] = where[row, column] + offsets.mean(axis=0)
            waiting.append(there)
    assert where.keys() == by_place.keys()
    return {by_place[key].label: offset for key, offset in where.items()}


def on_side(places: Array, axis: int, ends) -> Array:
    """The crosses of one side of a sheet, in order."""
    side = places[np.abs(places[:, axis] - ends(places[:, axis])) < 1e-3]
    return side[np.argsort(side[:, 1 - axis])]


def whole(sheets: list[PrintedSheet]) -> shapely.Geometry:
    where = glued(sheets)
    return shapely.union_all([translate(s.tape, *where[s.label]) for s in sheets])


@pytest.mark.parametrize(("turn", "y"), [(0, 3), (0, 131), (17, 0), (-24, 20)])
@pytest.mark.parametrize("paper", PAPERS)
def test_a_metre_is_a_metre_over_the_sheets(paper: str, turn: float, y: float) -> None:
    printing = laid_out(METRE.format(turn=turn, y=y).encode(), paper)
    sheets = printed(sheets_pdf(printing, "metre", catalogue("en")))
    assert len(sheets) > (4 if paper == "a4" else 2)
    tape = whole(sheets)
    assert tape.geom_type == "Polygon"
    corners = shapely.get_coordinates(shapely.minimum_rotated_rectangle(tape))[:4]
    sides = sorted(math.dist(a, b) for a, b in zip(corners, np.roll(corners, 1, 0), strict=True))
    assert sides[-1] == pytest.approx(1000, abs=NEVER_MORE)
    assert sides[0] == pytest.approx(50, abs=NEVER_MORE)
    assert shapely.area(tape) == pytest.approx(50_000, rel=1e-3)
    for sheet in sheets:
        assert sheet.paper in (pytest.approx(PAPERS[paper], abs=1e-3),
                               pytest.approx(PAPERS[paper][::-1], abs=1e-3))  # fmt: skip


def test_overlaps_are_printed_on_both_sheets() -> None:
    printing = laid_out(METRE.format(turn=0, y=0).encode(), overlap=20)
    sheets = printed(sheets_pdf(printing, "metre", catalogue("en")))
    where = glued(sheets)
    first, second, *_ = sorted(sheets, key=lambda sheet: where[sheet.label][0])
    both = shapely.intersection(
        translate(first.tape, *where[first.label]), translate(second.tape, *where[second.label])
    )
    xmin, _, xmax, _ = shapely.bounds(both)
    assert xmax - xmin == pytest.approx(20, abs=NEVER_MORE)


def covered(printing: Printing) -> shapely.Geometry:
    width, height = printing.part
    return shapely.union_all([
        shapely.box(sheet.left, sheet.top - height, sheet.left + width, sheet.top)
        for sheet in printing.sheets
    ])  # fmt: skip


def test_sheets_cover_the_floor_and_blank_ones_are_not_printed() -> None:
    printing = laid_out(METRE.format(turn=0, y=0).encode())
    assert shapely.covers(shapely.buffer(covered(printing), 1e-6), shapely.box(*printing.floor))
    used = [sheet for sheet in printing.sheets if not sheet.blank]
    assert 0 < len(used) < len(printing.sheets)
    overview = sheets_pdf(printing, "metre", catalogue("de")).split(b"endstream")[0]
    assert "1400 x 700 mm auf".encode("latin-1") in overview
    for sheet in printing.sheets:
        label = f"({sheet.label})" if sheet.blank else sheet.label
        escaped = label.replace("(", r"\(").replace(")", r"\)")
        assert f"({escaped}) Tj".encode() in overview


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"paper": "a9"}, "there is no paper 'a9'; valid are a4, a3"),
        ({"overlap": 0.0}, "the overlap is 0 mm; valid is 5 to 50"),
    ],
)
def test_what_cannot_be_printed_is_refused(change, words) -> None:
    with pytest.raises(SheetsError, match=re.escape(words)):
        laid_out(METRE.format(turn=0, y=0).encode(), **change)
    huge = METRE.replace("1400mm", "14000mm").replace("700mm", "7000mm")
    with pytest.raises(SheetsError, match="sheets are too many; valid are 400"):
        laid_out(huge.format(turn=0, y=0).encode())
