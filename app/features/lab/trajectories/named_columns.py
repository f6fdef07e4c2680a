"""Read tables whose header names the columns, in any order, such as EuRoC's CSV.

EuRoC's ground truth begins ``#timestamp [ns], p_RS_R_x [m], ..., q_RS_w [], q_RS_x [], ...``
(Burri et al., The EuRoC micro aerial vehicle datasets, IJRR 2016); others write ``stamp,x,y,z`` and
``q_w,q_x,q_y,q_z`` or ``qx,qy,qz,qw``, and of a robot on a floor ``time,x,y,yaw``. Columns with
other names are ignored."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from app.features.lab.trajectories.text_file import as_numbers, comments, number_from, numbered
from app.trajectories.trajectory import Trajectory, TrajectoryError
from robot.geometry import Array

QUANTITIES = ("stamp", "x", "y", "z", "qx", "qy", "qz", "qw")
PLANAR = ("stamp", "x", "y", "yaw")
VALID = (
    "columns of stamp, x, y, z, qx, qy, qz, qw in any order, with or without a unit, such as "
    "timestamp [ns], p_x [m], p_y, p_z, q_w, q_x, q_y, q_z; or of stamp, x, y, yaw"
)
SECONDS = {"s": 1.0, "sec": 1.0, "ms": 1e3, "us": 1e6, "ns": 1e9}
"""Number of each unit in one second."""
METRES = {"m": 1.0, "cm": 1e2, "mm": 1e3}
RADIANS = {"rad": 1.0, "deg": math.degrees(1), "°": math.degrees(1), "degrees": math.degrees(1)}
FASTEST_TURN = 10.0
"""Nobody turns so fast for long [rad/s]: then the yaw is in degrees."""
NANOSECONDS_FROM = 1e16
"""Stamps without a unit are nanoseconds if all are at least this: no date is so late in seconds."""
ENOUGH = 4
"""A comment with fewer names of quantities is not a header."""

_UNIT = re.compile(r"[\[(]([^\[\]()]*)[\])]")
_SUFFIX = re.compile(r"_(ns|us|ms|s|sec|m|cm|mm|rad|deg)$")
_STAMP = re.compile(r"(?:.*[._/])?(?:t|time|stamp|timestamp)")
_POSITION = re.compile(r"(?:(?:.*[._/])?(?:p|t|pos|position|translation)(?:_\w+)?[._/]?)?([xyz])")
_TURN = re.compile(r"(?:.*[._/])?(?:q|quat|quaternion|orientation|rotation)(?:_\w+)?[._/]?([wxyz])")
_YAW = re.compile(r"(?:.*[._/])?(?:yaw|theta|heading|psi|th)")


@dataclass(frozen=True, slots=True)
class HeaderRow:
    """The row that names the columns."""

    line: int
    """Line number."""
    cells: tuple[str, ...]
    commas: bool
    """Whether commas separate the cells; else spaces do."""


def header_of(text: str) -> HeaderRow | None:
    """Return the header of a table; None if no row names columns.

    The header is a row above all rows of numbers that does not begin with a number. A comment is a
    header if it has as many cells as the first row of numbers, and if it has commas or at least
    ENOUGH of its names are known.
    """
    headers: list[HeaderRow] = []
    for line, row in numbered(text):
        bare = row.lstrip("#%").strip()
        if bare == row and _is_number(_cells(row, "," in row)[0]):
            return next((item for item in reversed(headers) if _fits(item, row)), None)
        header = HeaderRow(line, tuple(_cells(bare, "," in bare)), "," in bare)
        if bare == row:
            return header if _known(header) else None
        headers.append(header)
    return None


def parse_named(text: str, source: str, header: HeaderRow) -> Trajectory:
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
    table = np.array(rows, dtype=np.float64).reshape(-1, len(columns))
    units = [_unit(header, name, column, source) for name, column in columns.items()]
    if not units[0]:
        units[0] = 1e9 if (np.abs(table[:, 0]) >= NANOSECONDS_FROM).all() else 1.0
    table /= [unit or 1.0 for unit in units]
    if tuple(columns) == PLANAR:
        if units[-1] is None:
            _require_radians(table[:, 0], table[:, 3], f"{source}, line {header.line}")
        table = np.column_stack([table[:, :3], _turned(table[:, 3])])
    return Trajectory.of_rows(
        table[:, 0], table[:, 1:4], table[:, 4:], source, comments(text), lines
    )


def _turned(yaw: Array) -> Array:
    """Return height and quaternions (n, 5) of headings (n,) [rad] on a floor."""
    nothing = np.zeros(len(yaw))
    with np.errstate(invalid="ignore"):  # not finite: left out later, and counted
        half = yaw / 2
        return np.column_stack([nothing, nothing, nothing, np.sin(half), np.cos(half)])


def _require_radians(stamps: Array, yaw: Array, where: str) -> None:
    """Raise TrajectoryError if headings without a unit can only be degrees."""
    steps, turns = np.diff(stamps), np.abs(np.diff(yaw))
    usable = np.isfinite(turns) & (steps > 0)
    rates = turns[usable] / steps[usable]
    wraps = np.count_nonzero(np.abs(turns[usable] - 360) < 90)
    if len(rates) and (wraps or np.quantile(rates, 0.9) > FASTEST_TURN):
        raise TrajectoryError(
            f"{where}: is the yaw in degrees? Then name its column yaw [deg], and if it is in "
            "radians, yaw [rad]"
        )


def _columns(header: HeaderRow, source: str) -> Mapping[str, int]:
    """Return the column of each quantity: of a pose in space, or else of one on a floor."""
    known = _known(header)
    in_space, on_floor = (_wrong(names, known) for names in (QUANTITIES, PLANAR))
    if not in_space:
        return {name: known[name][0] for name in QUANTITIES}
    if not on_floor:
        return {name: known[name][0] for name in PLANAR}
    wrong = on_floor if "yaw" in known else in_space
    raise TrajectoryError(
        f"{source}, line {header.line}: the header has {', '.join(wrong)}; valid are {VALID}"
    )


def _wrong(names: Iterable[str], known: Mapping[str, Sequence[int]]) -> list[str]:
    """Return in words which quantities have no column, or several."""
    return [
        f"{len(known[name])} columns of {name}" if name in known else f"none of {name}"
        for name in names
        if len(known.get(name, ())) != 1
    ]


def _known(header: HeaderRow) -> dict[str, list[int]]:
    """Return the columns by the quantity that they name."""
    result: dict[str, list[int]] = {}
    for column, cell in enumerate(header.cells):
        quantity = _quantity(_SUFFIX.sub("", _UNIT.sub("", cell).strip().lower()))
        if quantity:
            result.setdefault(quantity, []).append(column)
    # Beside the stamp of a message there may be when it was recorded.
    stamps = [column for column in result.get("stamp", ()) if "stamp" in header.cells[column]]
    if len(stamps) == 1:
        result["stamp"] = stamps
    return result


def _quantity(name: str) -> str | None:
    if turn := _TURN.fullmatch(name):
        return f"q{turn[1]}"
    if position := _POSITION.fullmatch(name):
        return position[1]
    if _YAW.fullmatch(name):
        return "yaw"
    return "stamp" if _STAMP.fullmatch(name) else None


def _unit(header: HeaderRow, name: str, column: int, source: str) -> float | None:
    """Return how many of a column's unit are one second, metre or radian; None if it names none."""
    cell = header.cells[column].lower()
    units = {"stamp": SECONDS, "yaw": RADIANS}.get(name, METRES)
    if name in QUANTITIES[4:]:
        return None
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


def _fits(header: HeaderRow, row: str) -> bool:
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
