"""Reads a trajectory of any kind; files of the TUM RGB-D benchmark are read and written here."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import numpy as np

from app.files import atomic_file
from app.lab.trajectories.motive import is_motive, parse_motive
from app.lab.trajectories.mrclam import content_of, parse_mrclam
from app.lab.trajectories.named_columns import header_of, parse_named
from app.lab.trajectories.text_file import (
    comments,
    number_from,
    numbered,
    read_text,
    rows_of_numbers,
)
from app.lab.trajectories.trajectory import Trajectory, TrajectoryError

COLUMNS = "stamp x y z qx qy qz qw"
FORMATS = ["%.9f"] + ["%.12f"] * 7


def parse_tum(text: str, source: str) -> Trajectory:
    """Read the text of a file; several poses may have the same stamp and all count, as in evo."""
    lines, rows = rows_of_numbers(text, source, COLUMNS)
    values = np.array(rows, dtype=np.float64).reshape(-1, 8)
    return Trajectory(
        values[:, 0], values[:, 1:4], values[:, 4:], source, comments(text), True, lines
    )


def write_tum(path: Path | str, trajectory: Trajectory, notes: Iterable[str] = ()) -> None:
    """Write a file; at any moment it is either complete or not there.

    Args:
        trajectory: what to write: stamps with 9 decimals, the rest with 12.
        notes: comment lines at the top.

    Raises:
        TrajectoryError: two different stamps would be written alike.
        OSError: the file cannot be written.
    """
    stamps = trajectory.stamps
    if ((np.diff(np.round(stamps, 9)) <= 0) & (np.diff(stamps) > 0)).any():
        raise TrajectoryError(f"{trajectory.name}: stamps are less than 1e-9 s apart")
    table = np.column_stack([trajectory.stamps, trajectory.positions, trajectory.quaternions])
    header = [f"# {line}" for note in (*notes, COLUMNS) for line in note.splitlines()]
    with atomic_file(Path(path)) as new, new.open("w", encoding="utf-8") as file:
        file.write("\n".join(header) + "\n")
        np.savetxt(file, table, fmt=FORMATS)


VALID = (
    f"TUM text ({COLUMNS}), the CSV of OptiTrack's Motive (begins with Format Version), "
    "MRCLAM text with its comments, a table with a header (stamp,x,y,z,q_w,q_x,q_y,q_z)"
)


def read_trajectory(path: Path | str, body: str | None = None) -> Trajectory:
    """Read a file of TUM or MRCLAM text, of Motive or EuRoC; it may be compressed by gzip.

    Args:
        body: which rigid body of a Motive file; needed if it has several.

    Raises:
        TrajectoryError: the file cannot be read or is not a trajectory; names file and line.
    """
    return parse_trajectory(read_text(Path(path)), str(path), body)


def parse_trajectory(text: str, source: str, body: str | None = None) -> Trajectory:
    """Read the text of a file; as in `read_trajectory`."""
    if is_motive(text):
        return parse_motive(text, source, body)
    if body is not None:
        raise TrajectoryError(f"{source}: only files of Motive have a rigid body {body!r}")
    if content_of(text) is not None:
        return parse_mrclam(text, source)
    header = header_of(text)
    if header is not None:
        return parse_named(text, source, header)
    _check_numeric(text, source)
    return parse_tum(text, source)


def _check_numeric(text: str, source: str) -> None:
    """Refuse a text of no known format: its first row does not begin with a number."""
    for line, row in numbered(text):
        if row.startswith("#"):
            continue
        try:
            number_from((row.replace(",", " ").split() or [""])[0])
        except ValueError as error:
            raise TrajectoryError(f"{source}, line {line}: {error}; valid are {VALID}") from error
        return
    raise TrajectoryError(f"{source} has no poses; valid are {VALID}")
