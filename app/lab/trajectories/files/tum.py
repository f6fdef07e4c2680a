"""Read and write trajectories as text in the format of the TUM RGB-D benchmark.

A line is ``stamp x y z qx qy qz qw`` [s, m, unit quaternion], and "#" begins a comment (Sturm et
al., A Benchmark for the Evaluation of RGB-D SLAM Systems, IROS 2012).
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import numpy as np

from app.files import atomic_file
from app.lab.trajectories.files.text_file import comments, rows_of_numbers
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
        path: of the file.
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
