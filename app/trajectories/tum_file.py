"""Writes a trajectory as text of the TUM RGB-D benchmark, one pose a line."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import numpy as np

from app.files import atomic_file
from app.trajectories.trajectory import Trajectory, TrajectoryError

COLUMNS = "stamp x y z qx qy qz qw"
FORMATS = ["%.9f"] + ["%.12f"] * 7


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
