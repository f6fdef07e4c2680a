"""Read the CSV that OptiTrack's Motive exports: poses of a rigid body by time.

The first line holds pairs of key and value (``Format Version,1.23,Take Name,...``). The header
above the data has rows of Type, Name, ID, in newer versions Parent, and of Rotation or Position;
its last row begins with ``Frame,Time (Seconds)`` and names the axes. Columns of markers, of
skeletons and of the mean marker error lie between those of rigid bodies. Where a body was lost,
its cells are empty."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

from app.features.lab.trajectories.bodies import chosen_body
from app.features.lab.trajectories.text_file import as_numbers
from app.trajectories.trajectory import Trajectory, TrajectoryError
from robot.geometry import Array

UNITS = {
    "Meters": 1.0,
    "Centimeters": 0.01,
    "Millimeters": 0.001,
    "Inches": 0.0254,
    "Feet": 0.3048,
}
ORDERS = ("XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX")
CLIMBS, CLEARLY = 0.02, 5.0
"""If positions spread by more than the first along y [m], and by more than the second times the
spread along z, then z is up: a robot does not climb."""
LONGEST_HEADER = 30
"""Largest number of rows above the data."""
Z_UP_FROM_Y_UP = Rotation.from_euler("x", 90, degrees=True)
"""Takes (x, y, z) to (x, -z, y)."""

Row = tuple[int, list[str]]
"""Line number and cells."""


@dataclass(frozen=True)
class _Body:
    """The columns of a rigid body, by axis."""

    rotation: tuple[int, ...]
    position: tuple[int, ...]


def is_motive(text: str) -> bool:
    """Whether a text is from Motive, by its first words."""
    return text.lstrip().lstrip('"').startswith("Format Version")


def parse_motive(text: str, source: str, body: str | None = None) -> Trajectory:
    """Read the text of a file; the trajectory has z up.

    Motive's y axis is up unless the user changed that. If the path spreads along y and hardly along
    z, then z is up already, as a robot does not climb. Else (x, y, z) becomes (x, -z, y), for the
    axes of the world and of the body.
    Euler angles are turns [deg] about the body's own axes, one after the other, as in OptiTrack's
    NatNet samples ("relative").

    Args:
        body: which rigid body; needed if there are several.

    Raises:
        TrajectoryError: the file is damaged or lacks this rigid body; names the line and what the
            file has.
    """
    rows = _rows(text, source)
    settings = _settings(rows[0][1])
    header = _header(rows, source)
    scale = _scale(settings, source)
    order = _order(settings, source)
    columns = _columns(header, _chosen(header, body, source), order, source)
    lines, table = _table(rows[rows.index(header[-1]) + 1 :], columns, source)
    if not lines:
        raise TrajectoryError(f"{source}: the rigid body is in no row; valid are poses in rows")
    # Check the poses as the file has them, before they are turned.
    count = len(columns.rotation)
    raw = table[:, 1 : count + 1] if order is None else _turns(table[:, 1 : count + 1], order)
    checked = Trajectory(table[:, 0], table[:, count + 1 :] * scale, raw, source, lines=lines)
    return _upright(checked, tuple(f"{key}: {value}" for key, value in settings.items()))


def _rows(text: str, source: str) -> list[Row]:
    """Return the rows that are not empty."""
    reader = csv.reader(io.StringIO(text))
    try:
        cells = ((reader.line_num, [cell.strip() for cell in row]) for row in reader)
        return [(line, row) for line, row in cells if any(row)]
    except csv.Error as error:
        raise TrajectoryError(f"{source}, line {reader.line_num}: {error}") from error


def _settings(cells: Sequence[str]) -> dict[str, str]:
    return dict(zip(cells[::2], cells[1::2], strict=False))


def _header(rows: list[Row], source: str) -> list[Row]:
    """Return the rows of the header: types first, names second, properties and axes last."""
    for index, (_, row) in enumerate(rows[:LONGEST_HEADER]):
        if row[0] == "Frame" and len(row) > 1 and row[1].startswith("Time"):
            if index < 4:
                break
            return rows[1 : index + 1]
    raise TrajectoryError(
        f"{source}: not Motive's header; valid are rows of Type, Name, ID and of Rotation and "
        'Position, then one that begins with "Frame,Time (Seconds)"'
    )


def _scale(settings: dict[str, str], source: str) -> float:
    units = settings.get("Length Units", "")
    if units not in UNITS:
        raise TrajectoryError(
            f"{source}, line 1: Length Units is {units!r}; valid are {', '.join(UNITS)}"
        )
    return UNITS[units]


def _order(settings: dict[str, str], source: str) -> str | None:
    """Return the order of the axes of Euler angles; None for quaternions."""
    rotation = settings.get("Rotation Type", "")
    if rotation == "Quaternion":
        return None
    if rotation not in ORDERS:
        raise TrajectoryError(
            f"{source}, line 1: Rotation Type is {rotation!r}; "
            f"valid are Quaternion, {', '.join(ORDERS)}"
        )
    return rotation


def _bodies(header: list[Row]) -> dict[str, list[int]]:
    """Return the columns of each rigid body."""
    types, names = header[0][1], header[1][1]
    result: dict[str, list[int]] = {}
    for column, kind in enumerate(types[: len(names)]):
        if kind == "Rigid Body":
            result.setdefault(names[column], []).append(column)
    return result


def _chosen(header: list[Row], body: str | None, source: str) -> str:
    """Return the name of the requested rigid body."""
    bodies = list(_bodies(header))
    line = header[1][0]
    if not bodies:
        raise TrajectoryError(f"{source}, line {header[0][0]}: no column is of a Rigid Body")
    return chosen_body(bodies, body, f"{source}, line {line}")


def _columns(header: list[Row], body: str, order: str | None, source: str) -> _Body:
    """Return the columns of a rigid body's rotation and position."""
    (line, properties), (_, axes) = header[-2], header[-1]
    width = min(len(properties), len(axes))
    column_of = {
        (properties[item], axes[item]): item for item in _bodies(header)[body] if item < width
    }
    rotation = [("Rotation", axis) for axis in order or "XYZW"]
    position = [("Position", axis) for axis in "XYZ"]
    missing = [" ".join(key) for key in rotation + position if key not in column_of]
    if missing:
        raise TrajectoryError(f"{source}, line {line}: {body!r} lacks {', '.join(missing)}")
    return _Body(
        tuple(column_of[key] for key in rotation), tuple(column_of[key] for key in position)
    )


def _table(rows: list[Row], body: _Body, source: str) -> tuple[list[int], Array]:
    """Read the rows where the body was seen.

    Returns:
        Line numbers (n,), and time, rotation and position (n, 1 + r + 3).
    """
    lines, table = [], []
    columns = (*body.rotation, *body.position)
    for line, row in rows:
        cells = [row[column] if column < len(row) else "" for column in (1, *columns)]
        if not any(cells[1:]):
            continue
        if not all(cells):
            raise TrajectoryError(f"{source}, line {line}: cells of the pose are empty, not all")
        table.append(as_numbers(cells, source, line))
        lines.append(line)
    return lines, np.array(table, dtype=np.float64).reshape(-1, len(columns) + 1)


def _turns(degrees: Array, order: str) -> Array:
    """Return the quaternions (n, 4) of Euler angles (n, 3) [deg] in the given order of axes."""
    quaternions = np.full((len(degrees), 4), np.nan)
    finite = np.isfinite(degrees).all(axis=1)
    if finite.any():
        quaternions[finite] = Rotation.from_euler(order, degrees[finite], degrees=True).as_quat()
    return quaternions


def _upright(trajectory: Trajectory, notes: tuple[str, ...]) -> Trajectory:
    """Return the trajectory with z up; a note says which axis was up in the file."""
    _, y, z = np.std(trajectory.positions, axis=0)
    if y > CLIMBS and y > CLEARLY * z:
        return replace(trajectory, notes=(*notes, "up: z"), lines=None)
    turned = Z_UP_FROM_Y_UP * Rotation.from_quat(trajectory.quaternions) * Z_UP_FROM_Y_UP.inv()
    return replace(
        trajectory,
        positions=trajectory.positions[:, [0, 2, 1]] * (1.0, -1.0, 1.0),
        quaternions=turned.as_quat(),
        notes=(*notes, "up: y"),
        lines=None,
    )
