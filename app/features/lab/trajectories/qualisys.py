"""Read the TSV that Qualisys Track Manager exports of rigid bodies ("6D"): poses by time.

Lines of a key and its values come first, then a row of names, in which each body has X, Y, Z [mm],
three angles, a residual and a rotation matrix, column by column. What the angles are is a setting
of the program that the file does not tell, so the matrix is read. A body that was lost has zeros or
empty cells.
"""

from __future__ import annotations

import numpy as np

from app.features.lab.trajectories.bodies import chosen_body
from app.features.lab.trajectories.rotation_matrices import quaternions_of
from app.features.lab.trajectories.text_file import as_numbers, numbered
from app.trajectories.trajectory import Trajectory, TrajectoryError

KEYS = ("FILE_VERSION\t", "NO_OF_FRAMES\t")
"""Begins of the first line."""
MILLIMETRES = 1000.0
FIRST_TURN = "Rot[0]"
BEFORE_TURN = 7
"""Columns of a body before its matrix."""
VALID = "a row of names with X Y Z Roll Pitch Yaw Residual Rot[0] to Rot[8] of each body"


def is_qualisys(text: str) -> bool:
    """Whether a text is from Qualisys, by its first words."""
    return text.lstrip().startswith(KEYS)


def parse_qualisys(text: str, source: str, body: str | None = None) -> Trajectory:
    """Read the rows where a body was seen.

    Args:
        body: which rigid body; needed if there are several.

    Raises:
        TrajectoryError: the file is damaged, has no bodies or lacks this one; says what it has.
    """
    settings, header, names = _header(text, source)
    where = f"{source}, line {header}"
    bodies = {
        names[start].removesuffix("X").strip(): start
        for start in range(len(names) - 15)
        if _is_body(names[start : start + 16])
    }
    if not bodies:
        raise TrajectoryError(f"{where}: no rigid body; valid is {VALID}")
    if "Time" not in names[:2]:
        raise TrajectoryError(f"{where}: no column Time; valid is an export with frame and time")
    start = bodies[chosen_body(bodies, body, where)]
    turn = start + BEFORE_TURN
    columns = [names.index("Time"), *range(start, start + 3), *range(turn, turn + 9)]
    lines, table = [], []
    for line, row in numbered(text):
        if line <= header:
            continue
        cells = row.split("\t")
        needed = [cells[column].strip() if column < len(cells) else "" for column in columns]
        if not all(needed):
            continue
        values = as_numbers(needed, source, line)
        if any(values[4:]) and np.isfinite(values).all():
            table.append(values)
            lines.append(line)
    if not lines:
        raise TrajectoryError(f"{source}: the rigid body is in no row; valid are poses in rows")
    poses = np.array(table, dtype=np.float64)
    # Column by column: the first three are the body's x axis.
    turns = poses[:, 4:].reshape(-1, 3, 3).transpose(0, 2, 1)
    return Trajectory(
        poses[:, 0],
        poses[:, 1:4] / MILLIMETRES,
        quaternions_of(turns, lines, source, VALID),
        source,
        tuple(f"{key}: {value}" for key, value in settings.items()),
        lines=lines,
    )


def _header(text: str, source: str) -> tuple[dict[str, str], int, list[str]]:
    """Return the settings, and the line and the cells of the row of names."""
    settings: dict[str, str] = {}
    for line, row in numbered(text):
        key, *values = (cell.strip() for cell in row.split("\t"))
        if FIRST_TURN in values:
            return settings, line, [key, *values]
        if key.replace("_", "").isalpha() and key.isupper():
            settings[key] = " ".join(values).strip()
            continue
        break
    held = settings.get("DATA_INCLUDED", "")
    raise TrajectoryError(
        f"{source} is Qualisys's TSV of {held or 'unknown data'}, without rigid bodies; valid is "
        f"that of 6D data, with its header: {VALID}"
    )


def _is_body(names: list[str]) -> bool:
    """Whether columns are those of a body; what its angles are called is a setting, too."""
    place, rest = names[:3], names[6:]
    begins = place[0].endswith("X") and place[1:] == ["Y", "Z"]
    return begins and rest == ["Residual", *(f"Rot[{item}]" for item in range(9))]
