"""Read tables whose header names the columns, in any order, such as EuRoC's CSV.

EuRoC's ground truth begins ``#timestamp [ns], p_RS_R_x [m], ..., q_RS_w [], q_RS_x [], ...``
(Burri et al., The EuRoC micro aerial vehicle datasets, IJRR 2016); others write ``stamp,x,y,z`` and
``q_w,q_x,q_y,q_z`` or ``qx,qy,qz,qw``. Columns with other names are ignored."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from app.lab.trajectories.text_file import as_numbers, comments, number_from, numbered
from app.lab.trajectories.trajectory import Trajectory, TrajectoryError

QUANTITIES = ("stamp", "x", "y", "z", "qx", "qy", "qz", "qw")
VALID = (
    "columns of stamp, x, y, z, qx, qy, qz, qw in any order, with or without a unit, such as "
    "timestamp [ns], p_x [m], p_y, p_z, q_w, q_x, q_y, q_z"
)
SECONDS = {"s": 1.0, "sec": 1.0, "ms": 1e3, "us": 1e6, "ns": 1e9}
"""Number of each unit in one second."""
METRES = {"m": 1.0, "cm": 1e2, "mm": 1e3}
NANOSECONDS_FROM = 1e16
"""Stamps without a unit are nanoseconds if all are at least this: no date is so late in seconds."""
ENOUGH = 4
"""A comment with fewer names of quantities is not a header."""

_UNIT = re.compile(r"[\[(]([^\[\]()]*)[\])]")
_SUFFIX = re.compile(r"_(ns|us|ms|s|sec|m|cm|mm)$")
_STAMP = re.compile(r"(?:.*[._])?(?:t|time|stamp|timestamp)")
_POSITION = re.compile(r"(?:(?:.*[._])?(?:p|t|pos|position|translation)(?:_\w+)?[._]?)?([xyz])")
_TURN = re.compile(r"(?:.*[._])?(?:q|quat|quaternion|orientation|rotation)(?:_\w+)?[._]?([wxyz])")


@dataclass(frozen=True, slots=True)
class Header:
    """The row that names the columns."""

    line: int
    """Line number."""
    cells: tuple[str, ...]
    commas: bool
    """Whether commas separate the cells; else spaces do."""


def header_of(text: str) -> Header | None:
    """Return the header of a table; None if no row names columns.

    The header is a row above all rows of numbers that does not begin with a number. A comment is a
    header if it has as many cells as the first row of numbers, and if it has commas or at least
    ENOUGH of its names are known.
    """
    headers: list[Header] = []
    for line, row in numbered(text):
        bare = row.lstrip("#%").strip()
        if bare == row and _is_number(_cells(row, "," in row)[0]):
            return next((item for item in reversed(headers) if _fits(item, row)), None)
        header = Header(line, tuple(_cells(bare, "," in bare)), "," in bare)
        if bare == row:
            return header if _known(header) else None
        headers.append(header)
    return None


def parse_named(text: str, source: str, header: Header) -> Trajectory:
    """Read the rows below the header.

    Raises:
        TrajectoryError: a quantity has no column, several columns or an unknown unit, or a row has
            another number of cells or no numbers; names file and line, and what is valid.
    """
    columns = _columns(header, source)
    lines, rows = [], []
    for line, row in numbered(text):
        if line <= header.line or row.startswith("#"):
            continue
        cells = _cells(row, header.commas)
        if len(cells) != len(header.cells):
            raise TrajectoryError(
                f"{source}, line {line}: {len(cells)} cells; "
                f"valid are {len(header.cells)}, as in the header in line {header.line}"
            )
        rows.append(as_numbers([cells[column] for column in columns.values()], source, line))
        lines.append(line)
    table = np.array(rows, dtype=np.float64).reshape(-1, len(QUANTITIES))
    stamp, *position = (_unit(header, columns[name], source) for name in QUANTITIES[:4])
    if not stamp:
        stamp = 1e9 if (np.abs(table[:, 0]) >= NANOSECONDS_FROM).all() else 1.0
    return Trajectory(
        table[:, 0] / stamp,
        table[:, 1:4] / [item or 1.0 for item in position],
        table[:, 4:],
        source,
        comments(text),
        True,
        lines,
    )


def _columns(header: Header, source: str) -> Mapping[str, int]:
    """Return the column of each quantity."""
    known = _known(header)
    wrong = [name for name in QUANTITIES if len(known.get(name, ())) != 1]
    if wrong:
        faults = [
            f"{len(known[name])} columns of {name}" if name in known else f"none of {name}"
            for name in wrong
        ]
        raise TrajectoryError(
            f"{source}, line {header.line}: the header has {', '.join(faults)}; valid are {VALID}"
        )
    return {name: known[name][0] for name in QUANTITIES}


def _known(header: Header) -> dict[str, list[int]]:
    """Return the columns by the quantity that they name."""
    result: dict[str, list[int]] = {}
    for column, cell in enumerate(header.cells):
        quantity = _quantity(_SUFFIX.sub("", _UNIT.sub("", cell).strip().lower()))
        if quantity:
            result.setdefault(quantity, []).append(column)
    return result


def _quantity(name: str) -> str | None:
    if turn := _TURN.fullmatch(name):
        return f"q{turn[1]}"
    if position := _POSITION.fullmatch(name):
        return position[1]
    return "stamp" if _STAMP.fullmatch(name) else None


def _unit(header: Header, column: int, source: str) -> float | None:
    """Return how many of a column's unit are a second or a metre; None if it names no unit."""
    cell = header.cells[column].lower()
    units = SECONDS if column == _known(header)["stamp"][0] else METRES
    given = _UNIT.search(cell) or _SUFFIX.search(cell)
    if given is None or not given[1].strip():
        return None
    unit = given[1].strip()
    if unit not in units:
        raise TrajectoryError(
            f"{source}, line {header.line}: {header.cells[column]!r} has the unit {unit!r}; "
            f"valid are {', '.join(units)}"
        )
    return units[unit]


def _fits(header: Header, row: str) -> bool:
    """Whether a comment is the header above the first row of numbers."""
    if len(header.cells) != len(_cells(row, header.commas)):
        return False
    return (header.commas and len(header.cells) > 1) or len(_known(header)) >= ENOUGH


def _cells(row: str, commas: bool) -> list[str]:
    if commas:
        return [cell.strip() for cell in row.split(",")]
    # A unit belongs to the name before it.
    return re.sub(r"\s+(?=[\[(])", "", row).split() or [""]


def _is_number(cell: str) -> bool:
    try:
        number_from(cell.split(maxsplit=1)[0] if cell else cell)
    except ValueError:
        return False
    return True
