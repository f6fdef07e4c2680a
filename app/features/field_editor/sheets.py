"""A field to scale over several sheets of paper, with marks to glue, as a PDF.

All lengths are millimetres. Sheets overlap: what lies in an overlap is printed on both. Crosses
stand where the middles of overlaps meet, so that each is on all sheets around it.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import shapely

from app.languages.catalogue import Catalogue
from robot.calibration.lens.page_files import POINTS, pdf_document
from robot.errors import BrickPoseError
from robot.fields.drawing.coats import coats_of
from robot.fields.drawing.svg_file import parse
from robot.fields.drawing.svg_shapes import read_page
from robot.fields.drawn_tape import HALF, Coat
from robot.fields.svg_field import TOLERANCE_MM

PAPERS = {"a4": (210.0, 297.0), "a3": (297.0, 420.0)}
"""Width and height [mm]."""
MARGIN = 10.0
"""What home printers leave white at each side [mm]."""
FOOT = 8.0
"""Room for a sheet's number and its ruler, above the lower margin [mm]."""
OVERLAPS = (5.0, 50.0)
"""Narrowest and widest overlap [mm]."""
MOST_SHEETS = 400
CROSS = 8.0
"""Arm of a cross [mm]."""
RULER = 100.0
"""[mm]"""
Box = tuple[float, float, float, float]


class SheetsError(BrickPoseError, ValueError):
    """A field cannot be printed so; the message says what is valid."""


@dataclass(frozen=True)
class Sheet:
    """One sheet, and the part of the floor that is printed on it."""

    row: int
    """0 is at the top."""
    column: int
    left: float
    top: float
    """Of the part, in the map frame [mm], y up."""
    blank: bool

    @property
    def label(self) -> str:
        """Its name: letters for rows, numbers for columns."""
        return f"{_letters(self.row)}{self.column + 1}"


@dataclass(frozen=True, eq=False)
class Printing:
    """How a field lies on sheets."""

    paper: tuple[float, float]
    overlap: float
    floor: Box
    """xmin, ymin, xmax, ymax [mm]."""
    rows: int
    columns: int
    sheets: tuple[Sheet, ...]
    coats: tuple[Coat, ...]

    @property
    def part(self) -> tuple[float, float]:
        """Width and height [mm] of the floor on one sheet."""
        return _part(self.paper)


def laid_out(content: bytes, paper: str = "a4", overlap: float = 10.0) -> Printing:
    """Return how a drawing lies on sheets, upright or across, whichever takes fewer.

    Raises:
        SvgError: the drawing cannot be used.
        SheetsError: there is no such paper or overlap, or there would be too many sheets.
    """
    if paper not in PAPERS:
        raise SheetsError(f"there is no paper {paper!r}; valid are {', '.join(PAPERS)}")
    if not OVERLAPS[0] <= overlap <= OVERLAPS[1]:
        low, high = OVERLAPS
        raise SheetsError(f"the overlap is {overlap:g} mm; valid is {low:g} to {high:g}")
    page = read_page(parse(content), TOLERANCE_MM)
    left, top = -page.origin[0], page.origin[1]
    floor = (left, top - page.size.height, left + page.size.width, top)
    # A light floor stays paper.
    coats = tuple(coat for coat in coats_of(page, TOLERANCE_MM) if not _is_paper(coat, floor))
    upright = PAPERS[paper]
    size = min((upright, upright[::-1]), key=lambda each: math.prod(_counts(floor, each, overlap)))
    rows, columns = _counts(floor, size, overlap)
    if rows * columns > MOST_SHEETS:
        raise SheetsError(f"{rows * columns} sheets are too many; valid are {MOST_SHEETS}")
    width, height = _part(size)
    sheets = []
    for row in range(rows):
        for column in range(columns):
            x, y = floor[0] + column * (width - overlap), floor[3] - row * (height - overlap)
            area = shapely.box(x / 1e3, (y - height) / 1e3, (x + width) / 1e3, y / 1e3)
            blank = not any(shapely.intersects(coat.layer.area, area) for coat in coats)
            sheets.append(Sheet(row, column, x, y, blank))
    return Printing(size, overlap, floor, rows, columns, tuple(sheets), coats)


def sheets_pdf(printing: Printing, name: str, own: Catalogue) -> bytes:
    """Return the sheets with anything on them, after a page that shows how they lie."""
    width, height = printing.paper
    pages = [(width, height, "\n".join(_overview(printing, name, own)))]
    for sheet in printing.sheets:
        if not sheet.blank:
            pages.append((width, height, "\n".join(_sheet(printing, sheet, name, own))))
    return pdf_document(pages)


def _part(paper: tuple[float, float]) -> tuple[float, float]:
    return paper[0] - 2 * MARGIN, paper[1] - 2 * MARGIN - FOOT


def _counts(floor: Box, paper: tuple[float, float], overlap: float) -> tuple[int, int]:
    width, height = _part(paper)
    rows = math.ceil((floor[3] - floor[1] - overlap) / (height - overlap) - 1e-9)
    columns = math.ceil((floor[2] - floor[0] - overlap) / (width - overlap) - 1e-9)
    return max(rows, 1), max(columns, 1)


def _is_paper(coat: Coat, floor: Box) -> bool:
    """Return whether a coat is a light floor: it is left as the paper is."""
    xmin, ymin, xmax, ymax = floor
    whole = shapely.box(xmin / 1000, ymin / 1000, xmax / 1000, ymax / 1000)
    covers = shapely.covers(shapely.buffer(coat.layer.area, 1e-6), whole)
    return coat.width is None and coat.layer.grey >= HALF and bool(covers)


# --- one sheet: its origin is the lower left corner of the paper, in points ---------------------


def _sheet(printing: Printing, sheet: Sheet, name: str, own: Catalogue) -> Iterator[str]:
    width, height = printing.part
    bottom = MARGIN + FOOT
    # From the map frame [m] to the paper [points]; all that follows is in m.
    scale = POINTS * 1000
    x, y = (MARGIN - sheet.left) * POINTS, (bottom + height - sheet.top) * POINTS
    clip = " ".join(f"{value * POINTS:.6f}" for value in (MARGIN, bottom, width, height))
    yield f"q {clip} re W n"
    yield f"{scale:.8f} 0 0 {scale:.8f} {x:.6f} {y:.6f} cm"
    part = shapely.box(
        sheet.left / 1e3, (sheet.top - height) / 1e3, (sheet.left + width) / 1e3, sheet.top / 1e3
    )
    for coat in printing.coats:
        yield from _painted(shapely.intersection(coat.layer.area, part), _tone(coat))
    yield "Q"
    yield from _crosses(printing, sheet)
    words = own.t(
        "{name}: sheet {sheet}, rows A to {rows}, columns 1 to {columns}; overlap {overlap} mm",
        name=name,
        sheet=sheet.label,
        rows=_letters(printing.rows - 1),
        columns=printing.columns,
        overlap=f"{printing.overlap:g}",
    )
    yield _written(words, MARGIN, MARGIN + 4.6, 2.8)
    yield from _ruler(MARGIN + printing.part[0] - RULER, MARGIN, own)


def _tone(coat: Coat) -> float:
    """Return how light its paint is on white paper, 0 to 1."""
    return 1 - coat.layer.alpha * (1 - coat.layer.grey / 255)


def _painted(area: shapely.Geometry, tone: float) -> Iterator[str]:
    for polygon in shapely.get_parts(area):
        if polygon.geom_type != "Polygon" or polygon.is_empty:
            continue
        rings = [polygon.exterior, *polygon.interiors]
        yield f"{tone:.3f} g " + " ".join(map(_ring, rings)) + " f*"


def _ring(ring: shapely.LinearRing) -> str:
    places = [f"{x:.7f} {y:.7f}" for x, y in shapely.get_coordinates(ring)[:-1].tolist()]
    return f"{places[0]} m " + " ".join(f"{place} l" for place in places[1:]) + " h"


def _crosses(printing: Printing, sheet: Sheet) -> Iterator[str]:
    """Yield crosses along the middles of a sheet's overlaps, and lines where overlaps end."""
    width, height = printing.part
    half, bottom = printing.overlap / 2, MARGIN + FOOT
    xs = MARGIN + half, MARGIN + width / 2, MARGIN + width - half
    ys = bottom + half, bottom + height / 2, bottom + height - half
    beside = [xs[0]] * (sheet.column > 0) + [xs[2]] * (sheet.column < printing.columns - 1)
    above = [ys[2]] * (sheet.row > 0) + [ys[0]] * (sheet.row < printing.rows - 1)
    yield "q"
    places = {(x, y) for x in beside for y in ys} | {(x, y) for x in xs for y in above}
    for x, y in sorted(places):
        yield from _cross(x, y)
    yield f"{0.15 * POINTS:.3f} w 0.55 G [2 2] 0 d"
    for x in beside:
        edge = x + half if x == xs[0] else x - half
        yield _line(edge, bottom, edge, bottom + height)
    for y in above:
        edge = y + half if y == ys[0] else y - half
        yield _line(MARGIN, edge, MARGIN + width, edge)
    yield "Q"


def _cross(x: float, y: float) -> Iterator[str]:
    # White below it: it is seen on tape, too.
    for grey, wide in ((1, 0.6), (0, 0.1)):
        yield f"{grey} G {wide * POINTS:.3f} w"
        yield _line(x - CROSS / 2, y, x + CROSS / 2, y)
        yield _line(x, y - CROSS / 2, x, y + CROSS / 2)


def _line(x: float, y: float, to_x: float, to_y: float) -> str:
    return (
        " ".join(f"{value * POINTS:.6f}" for value in (x, y))
        + " m "
        + " ".join(f"{value * POINTS:.6f}" for value in (to_x, to_y))
        + " l S"
    )


def _ruler(left: float, y: float, own: Catalogue) -> Iterator[str]:
    yield f"q {0.2 * POINTS:.3f} w 0 G"
    yield _line(left, y, left + RULER, y)
    for mark in range(0, int(RULER) + 1, 10):
        yield _line(left + mark, y, left + mark, y + (3 if mark % 50 == 0 else 1.5))
    yield "Q"
    yield _written(own.t("100 mm: measure it"), left - 32, y, 2.8)


def _written(words: str, x: float, y: float, size: float) -> str:
    safe = words.replace("\\", r"\\").replace("(", r"\(").replace(")", r"\)")
    return f"BT 0 g /F {size * POINTS:.3f} Tf {x * POINTS:.3f} {y * POINTS:.3f} Td ({safe}) Tj ET"


# --- the page that shows how sheets lie ----------------------------------------------------------


def _overview(printing: Printing, name: str, own: Catalogue) -> Iterator[str]:
    paper_width, paper_height = printing.paper
    xmin, ymin, xmax, ymax = printing.floor
    width, height = printing.part
    step_x, step_y = width - printing.overlap, height - printing.overlap
    used = sum(not sheet.blank for sheet in printing.sheets)
    lines = [
        own.t(
            "{name}: {width} x {height} mm on {used} sheets",
            name=name,
            width=f"{xmax - xmin:g}",
            height=f"{ymax - ymin:g}",
            used=used,
        ),
        own.t("Print at 100 % (true size, not fitted to the page), and measure the ruler: 100 mm."),
        own.t("Lay the sheets so that crosses lie on crosses, and glue them."),
        own.t("At dashed lines the next sheet begins. Sheets in brackets are blank: not printed."),
    ]
    y = paper_height - MARGIN - 6
    for number, words in enumerate(lines):
        yield _written(words, MARGIN, y, 5.0 if number == 0 else 3.2)
        y -= 8 if number == 0 else 5.5
    room = paper_width - 2 * MARGIN, y - MARGIN
    across = step_x * printing.columns + printing.overlap
    down = step_y * printing.rows + printing.overlap
    scale = min(room[0] / across, room[1] / down)
    left, top = MARGIN, y
    factor = scale * POINTS * 1000
    yield "q"
    yield (
        f"{factor:.8f} 0 0 {factor:.8f} {left * POINTS - xmin * scale * POINTS:.6f} "
        f"{top * POINTS - ymax * scale * POINTS:.6f} cm"
    )
    for coat in printing.coats:
        # Paler, so that numbers are read on it.
        yield from _painted(coat.layer.area, 0.55 + 0.45 * _tone(coat))
    yield "Q"
    yield f"q {0.15 * POINTS:.3f} w 0 G"
    for sheet in printing.sheets:
        x, high = left + (sheet.left - xmin) * scale, top - (ymax - sheet.top) * scale
        low = high - height * scale
        corners = [(x, low), (x + width * scale, low), (x + width * scale, high), (x, high)]
        for corner, following in zip(corners, corners[1:] + corners[:1], strict=True):
            yield _line(*corner, *following)
        label = f"({sheet.label})" if sheet.blank else sheet.label
        size = min(8.0, 0.2 * width * scale)
        yield _written(label, x + width * scale / 2 - size, low + height * scale / 2, size)
    yield "Q"


def _letters(row: int) -> str:
    """Return A to Z, AA, AB ...

    >>> _letters(0), _letters(25), _letters(26)
    ('A', 'Z', 'AA')
    """
    text, number = "", row + 1
    while number:
        number, digit = divmod(number - 1, 26)
        text = chr(ord("A") + digit) + text
    return text
