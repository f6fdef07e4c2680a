"""Read poses as ``ros2 topic echo --csv`` prints them: without a header, all fields of a message.

Seconds and nanoseconds of the stamp come first, then one or two names of frames, then position and
quaternion; covariances and twist follow.
"""

from __future__ import annotations

import numpy as np

from app.features.lab.trajectories.text_file import as_numbers, number_from, numbered
from app.trajectories.trajectory import Trajectory, TrajectoryError

FRAMES = (1, 2)
"""Numbers of frames' names: of a PoseStamped (or with covariance), and of an Odometry."""
POSE = 7


def is_echoed(text: str) -> bool:
    """Whether the first row is a printed message with a stamp, frames and a pose."""
    return _frames_of(next((row for _, row in numbered(text)), "")) is not None


def parse_echoed(text: str, source: str) -> Trajectory:
    """Read the poses of printed messages.

    Raises:
        TrajectoryError: a row is none; names file and line.
    """
    lines, rows = [], []
    printed = numbered(text)
    for line, row in printed:
        frames = _frames_of(row)
        if frames is None and line == printed[-1][0]:
            break  # Ctrl-C came in the middle of the last one
        if frames is None:
            raise TrajectoryError(
                f"{source}, line {line}: no printed message; valid are those of `ros2 topic echo "
                "--csv` on an Odometry or PoseStamped"
            )
        cells = row.split(",")
        pose = slice(2 + frames, 2 + frames + POSE)
        rows.append(as_numbers([*cells[:2], *cells[pose]], source, line))
        lines.append(line)
    table = np.array(rows, dtype=np.float64).reshape(-1, 2 + POSE)
    stamps = table[:, 0] + 1e-9 * table[:, 1]
    return Trajectory.of_rows(stamps, table[:, 2:5], table[:, 5:], source, (), lines)


def _frames_of(row: str) -> int | None:
    """Return how many names of frames a printed message has; None if the row is none."""
    cells = row.split(",")
    for frames in FRAMES:
        begin = [_is_number(cell) for cell in cells[: 2 + frames + POSE]]
        if begin == [True] * 2 + [False] * frames + [True] * POSE:
            return frames
    return None


def _is_number(cell: str) -> bool:
    try:
        number_from(cell)
    except ValueError:
        return False
    return True
