"""Read the CSV that Vicon's Tracker and Nexus export of rigid bodies: poses by frame.

A section begins with a line of what it has (Objects or Segments) and one of its rate. Rows of the
bodies' names, of ``Frame,Sub Frame,RX,RY,RZ,TX,TY,TZ`` and of units follow, and it ends at an empty
line. Where a body was lost, its cells are empty.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator, Sequence

import numpy as np
from scipy.spatial.transform import Rotation

from app.features.lab.trajectories.bodies import chosen_body
from app.features.lab.trajectories.named_columns import METRES, RADIANS
from app.features.lab.trajectories.text_file import as_numbers
from app.features.lab.trajectories.unstamped import UNDERSTOOD
from app.trajectories.trajectory import Trajectory, TrajectoryError
from robot.geometry import Array, heading_angles, heading_vectors

SECTIONS = ("Objects", "Segments")
OTHERS = ("Trajectories", "Joints", "Model Outputs", "Devices", "Bones")
BEGIN = "Frame,Sub Frame"
PLACE, QUATERNION, ANGLES = ("TX", "TY", "TZ"), ("RX", "RY", "RZ", "RW"), ("RX", "RY", "RZ")
HEADINGS_AGREE = 0.01
"""Angles are read if what they may mean gives the same headings within this [rad]."""
LABEL = "Global Angle "
"""What Tracker writes before the name of an object."""
VALID = "an export of objects (Tracker) or segments (Nexus)"

Row = tuple[int, list[str]]
"""Line number and cells."""


def is_vicon(text: str) -> bool:
    """Whether a text is from Vicon, by its first lines."""
    first, *following = (row.replace('"', "").strip() for row in text.lstrip().split("\n", 8)[:8])
    title = first.partition(",")[0]
    return title in (*SECTIONS, *OTHERS) and any(row.startswith(BEGIN) for row in following)


def parse_vicon(text: str, source: str, body: str | None = None) -> Trajectory:
    """Read the rows where a body was seen.

    Stamps are numbers of frames, divided by their rate. What three angles mean is a setting that
    the file does not tell. On a floor all meanings have the same heading, which alone is taken.

    Args:
        body: which rigid body; needed if there are several.

    Raises:
        TrajectoryError: the file is damaged, has no bodies or lacks this one, or it depends on the
            meaning of angles; says what it has.
    """
    section = _section(text, source)
    (line, rate_cells), (named, names), (_, axes), (_, units), *rows = section
    (rate,) = as_numbers(rate_cells[:1], source, line)
    if not 0 < rate < np.inf:
        raise TrajectoryError(f"{source}, line {line}: the rate is {rate:g}; valid is above 0")
    bodies = _bodies(names)
    where = f"{source}, line {named}"
    if not bodies:
        raise TrajectoryError(f"{where}: no body has a name; valid is {VALID}")
    column_of = {axes[item]: item for item in bodies[chosen_body(bodies, body, where)]
                 if item < len(axes)}  # fmt: skip
    turn = QUATERNION if "RW" in column_of else ANGLES
    missing = [name for name in (*turn, *PLACE) if name not in column_of]
    if missing:
        raise TrajectoryError(f"{where}: the body lacks {', '.join(missing)}; valid is {VALID}")
    columns = [column_of[name] for name in (*PLACE, *turn)]
    lines, table = _table(rows, columns, source)
    table[:, 0] /= rate
    table[:, 1:4] /= _units(units, columns[:3], METRES, f"{source}, line {named + 2}")
    if turn is QUATERNION:
        return Trajectory(table[:, 0], table[:, 1:4], table[:, 4:], source, lines=lines)
    angles = table[:, 4:] / _units(units, columns[3:], RADIANS, f"{source}, line {named + 2}")
    headings = _headings(angles, lines, source)
    half, nothing = heading_vectors(headings / 2), np.zeros(len(headings))
    quaternions = np.column_stack([nothing, nothing, half[:, 1], half[:, 0]])
    note = f"{UNDERSTOOD} of the angles of {source} the heading is taken, and no tilt"
    return Trajectory(table[:, 0], table[:, 1:4], quaternions, source, (note,), lines=lines)


def _rows(text: str) -> Iterator[Row]:
    reader = csv.reader(io.StringIO(text))
    for row in reader:
        yield reader.line_num, [cell.strip() for cell in row] or [""]


def _section(text: str, source: str) -> list[Row]:
    """Return the rows of the section with bodies, after its title."""
    try:
        rows = list(_rows(text))
    except csv.Error as error:
        raise TrajectoryError(f"{source}: no readable CSV of Vicon: {error}") from error
    begin = next((place for place, (_, row) in enumerate(rows) if row[0] in SECTIONS), None)
    if begin is None:
        raise TrajectoryError(
            f"{source} is Vicon's CSV of {rows[0][1][0]}, without rigid bodies; valid is {VALID}"
        )
    section = rows[begin + 1 :]
    end = next((place for place, (_, row) in enumerate(section) if not any(row)), len(section))
    if end < 4 or ",".join(section[2][1][:2]) != BEGIN:
        raise TrajectoryError(
            f"{source}, line {rows[begin][0]}: not Vicon's header; valid are rows of rate, names, "
            "axes and units"
        )
    return section[:end]


def _bodies(names: Sequence[str]) -> dict[str, range]:
    """Return the columns of each body."""
    begins = [place for place, name in enumerate(names) if name]
    ends = [*begins[1:], len(names) + len(QUATERNION + PLACE)]
    return {_name(names[begin]): range(begin, end) for begin, end in zip(begins, ends, strict=True)}


def _name(label: str) -> str:
    """Return the name of a body; Tracker's objects have it twice, with a colon between."""
    name = label.removeprefix(LABEL)
    subject, _, segment = name.partition(":")
    return subject if subject == segment else name


def _table(rows: list[Row], columns: list[int], source: str) -> tuple[list[int], Array]:
    """Return line numbers (n,), and frame, place and turn (n, 1 + 3 + k) where a body was seen."""
    lines, table = [], []
    for line, row in rows:
        cells = [row[column] if column < len(row) else "" for column in (0, *columns)]
        if all(cells):
            table.append(as_numbers(cells, source, line))
            lines.append(line)
    if not lines:
        raise TrajectoryError(f"{source}: the rigid body is in no row; valid are poses in rows")
    return lines, np.array(table, dtype=np.float64)


def _units(
    units: Sequence[str], columns: Sequence[int], known: dict[str, float], where: str
) -> Array:
    """Return how many of each column's unit are one metre or radian."""
    given = [units[column] if column < len(units) else "" for column in columns]
    wrong = [unit for unit in given if unit not in known]
    if wrong:
        raise TrajectoryError(f"{where}: the unit is {wrong[0]!r}; valid are {', '.join(known)}")
    return np.array([known[unit] for unit in given])


def _headings(angles: Array, lines: Sequence[int], source: str) -> Array:
    """Return the headings (n,) [rad] of angles (n, 3), if they do not depend on their meaning."""
    if not np.isfinite(angles).all():
        line = lines[int(np.argmin(np.isfinite(angles).all(axis=1)))]
        raise TrajectoryError(f"{source}, line {line}: a number is not finite; valid are numbers")
    meanings = [
        Rotation.from_rotvec(angles),
        Rotation.from_euler("XYZ", angles),
        Rotation.from_euler("xyz", angles),
    ]
    headings = [heading_angles(each.as_matrix()[:, :2, 0]) for each in meanings]
    apart = [np.abs((each - headings[0] + np.pi) % (2 * np.pi) - np.pi) for each in headings]
    worst = np.max(apart, axis=0)
    if (worst > HEADINGS_AGREE).any():
        line = lines[int(np.argmax(worst > HEADINGS_AGREE))]
        raise TrajectoryError(
            f"{source}, line {line}: the body is so tilted that its heading depends on what RX, RY "
            "and RZ mean, which the file does not tell; valid is an export of quaternions (RX, RY, "
            "RZ, RW)"
        )
    return headings[0]
