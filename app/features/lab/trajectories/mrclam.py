"""Read text files of the UTIAS multi-robot data set (MRCLAM): truth or wheel odometry of a robot.

Leung, Halpern, Barfoot, Liu, The UTIAS Multi-Robot Cooperative Localization and Mapping Dataset,
IJRR 2011. The comments at the top say which of the two a file holds."""

from __future__ import annotations

from enum import Enum

import numpy as np

from app.features.lab.trajectories.text_file import comments, numbered, rows_of_numbers
from app.trajectories.trajectory import Trajectory, TrajectoryError
from robot.geometry import Array, heading_vectors

FASTEST = 1e6
"""A velocity beyond this [m/s, rad/s] is invalid."""


class Content(Enum):
    """What a file holds."""

    TRUTH = "time x y orientation"
    ODOMETRY = "time forward-velocity angular-velocity"


def content_of(text: str) -> Content | None:
    """Return what a file holds, by the comments at its top; None for another kind of file."""
    for _, line in numbered(text):
        if not line.startswith("#"):
            return None
        words = line.lower()
        if "forward velocity" in words:
            return Content.ODOMETRY
        if "orientation" in words and "time" in words:
            return Content.TRUTH
    return None


def parse_mrclam(text: str, source: str) -> Trajectory:
    """Read the text of a file of truth or of odometry.

    Odometry consists of a forward velocity [m/s] and a turn rate [rad/s] that hold until the next
    line. It is integrated exactly from (0, 0, 0): from line to line the path is an arc. Real files
    sometimes repeat a stamp: the last of such lines counts, as the others hold for no time.

    Raises:
        TrajectoryError: the text is neither, or not a trajectory; names file and line.
    """
    content = content_of(text)
    if content is None:
        valid = " or ".join(repr(item.value) for item in Content)
        raise TrajectoryError(f"{source}: no comment tells what it holds; valid are {valid}")
    lines, rows = rows_of_numbers(text, source, content.value)
    table = np.array(rows, dtype=np.float64).reshape(-1, len(content.value.split()))
    if content is Content.TRUTH:
        return Trajectory.of_poses(table[:, 0], table[:, 1:], source, comments(text), lines)
    return _followed(table, source, comments(text), lines)


def _followed(table: Array, source: str, notes: tuple[str, ...], lines: list[int]) -> Trajectory:
    """Return the path of a robot with the given velocities."""
    wild = ~(np.abs(table[:, 1:]) <= FASTEST).all(axis=1)
    if wild.any():
        line = lines[int(np.argmax(wild))]
        raise TrajectoryError(f"{source}, line {line}: valid are velocities up to {FASTEST:g}")
    last = np.append(np.diff(table[:, 0]) != 0, True)[: len(table)]
    kept = table[last]
    numbers = [number for number, item in zip(lines, last, strict=True) if item]
    # The stamps are checked before they are integrated over.
    Trajectory.of_poses(kept[:, 0], np.zeros((len(kept), 3)), source, notes, numbers)
    return Trajectory.of_poses(kept[:, 0], integrated(*kept.T), source, notes, numbers)


def integrated(stamps: Array, forward: Array, turning: Array) -> Array:
    """Integrate velocities (n,) to poses (n, 3) [m, m, rad] from (0, 0, 0).

    A velocity holds until the next stamp, so each step is an arc (Probabilistic Robotics, Table
    5.3). Its chord has the length v dt sin(a) / a and the direction of the heading in its middle,
    with a half the angle turned.
    """
    durations = np.diff(stamps)
    half_turns = turning[:-1] * durations / 2
    headings = np.concatenate([[0.0], np.cumsum(2 * half_turns)])
    # np.sinc(x) is sin(pi x) / (pi x).
    chords = forward[:-1] * durations * np.sinc(half_turns / np.pi)
    steps = chords[:, None] * heading_vectors(headings[:-1] + half_turns)
    positions = np.vstack([np.zeros((1, 2)), np.cumsum(steps, axis=0)])
    return np.column_stack([positions, headings])
