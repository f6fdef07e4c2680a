"""Read the poses of a graph as g2o and GTSAM write it.

Each line begins with what it is. Edges and landmarks are left out. A vertex has a number, and no
stamp.
"""

from __future__ import annotations

import re

import numpy as np

from app.features.lab.trajectories.text_file import as_numbers, comments, numbered
from app.features.lab.trajectories.unstamped import stamps_of
from app.trajectories.trajectory import Trajectory, TrajectoryError
from robot.geometry import heading_vectors

ON_FLOOR = ("VERTEX_SE2", "VERTEX2")
"""Of g2o, and of TORO before it: number, x, y [m], theta [rad]."""
IN_SPACE = "VERTEX_SE3:QUAT"
"""Number, x, y, z [m], qx, qy, qz, qw."""
VALID = "VERTEX_SE2 number x y theta, or VERTEX_SE3:QUAT number x y z qx qy qz qw"

_NUMBER = re.compile(r"[0-9]{1,20}")
_WORD = re.compile(r"(VERTEX|EDGE|FIX|PARAMS)[A-Z0-9_]*(:[A-Z]+)?")


def is_pose_graph(text: str) -> bool:
    """Whether the first line that is no comment begins as one of g2o."""
    words = (row.split(maxsplit=1)[0] for _, row in numbered(text) if not row.startswith("#"))
    return _WORD.fullmatch(next(words, "")) is not None


def parse_pose_graph(text: str, source: str, times: str | None = None) -> Trajectory:
    """Read the vertices in the order of their numbers.

    Args:
        times: as in `stamps_of`.

    Raises:
        TrajectoryError: there are none, or a line is no pose; names file and line.
    """
    poses: dict[int, tuple[int, list[float]]] = {}
    for line, row in numbered(text):
        word, *cells = row.split()
        planar = word in ON_FLOOR
        if not (planar or word == IN_SPACE):
            continue
        if len(cells) != (4 if planar else 8) or not _NUMBER.fullmatch(cells[0]):
            raise TrajectoryError(f"{source}, line {line}: valid are {VALID}")
        number = int(cells[0])
        if number in poses:
            raise TrajectoryError(
                f"{source}, line {line}: vertex {number} is in line {poses[number][0]}, too; valid "
                "is one robot's graph"
            )
        values = as_numbers(cells[1:], source, line)
        poses[number] = line, _in_space(*values) if planar else values
    if not poses:
        raise TrajectoryError(f"{source} is a graph without poses; valid are lines of {VALID}")
    ordered = [poses[number] for number in sorted(poses)]
    lines = [line for line, _ in ordered]
    table = np.array([values for _, values in ordered], dtype=np.float64)
    stamps, notes = stamps_of(len(table), source, times)
    return Trajectory(
        stamps, table[:, :3], table[:, 3:], source, comments(text) + notes, True, lines
    )


def _in_space(x: float, y: float, theta: float) -> list[float]:
    with np.errstate(invalid="ignore"):  # an infinite angle gives NaN, which is refused
        cosine, sine = heading_vectors(np.array([theta / 2]))[0].tolist()
    return [x, y, 0.0, 0.0, 0.0, sine, cosine]
