"""Finds where a scan fits a likelihood field best, within a window (correlative scan matching).

Branch and bound (Hess, Kohler, Rapp and Andor 2016): squares of positions are bounded from above by
the coarser levels of the field, and only those are looked into that may hold a better fit.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from robot.compiling import compiled
from robot.geometry import Array, Pose2
from robot.mapping.graph.likelihood_pyramid import CELL, Levels, LikelihoodPyramid

PRIOR = 0.02
"""Share of the best fit that half a squared deviation from the supposed pose costs."""
STACK = 64
"""Squares that wait at most: three a level."""
NOWHERE = np.zeros(3)
"""Inverse deviations of a pose that is supposed nowhere: all are alike."""
Whole = NDArray[np.integer]


class Window(NamedTuple):
    """Where a pose is looked for."""

    pose: Pose2
    """Its middle."""
    half: Array
    """(3,) how far around it [m, m, rad]."""
    inverse_sd: Array = NOWHERE
    """(3,) of the supposed pose; zeros if all in the window are as likely [1/m, 1/m, 1/rad]."""


def best_pose(
    field: LikelihoodPyramid, points: Array, window: Window, least: float
) -> tuple[Pose2, float] | None:
    """Return the pose at which points (n, 2) fit best, and how well: 0 to 1.

    None means that they fit worse than ``least`` everywhere in the window.
    """
    far = max(float(np.hypot(*points.T).max()), 1.0)
    step = CELL / far
    pose, score = branch_and_bound(
        field.levels,
        (window.pose.to_array()[:2] - field.corner) / CELL,
        window.pose.theta,
        points / CELL,
        np.ceil(window.half[:2] / CELL).astype(np.int64),
        step,
        math.ceil(window.half[2] / step),
        window.inverse_sd * (CELL, CELL, step),
        least,
    )
    if score <= least:
        return None
    x, y, turn = pose
    return Pose2(x * CELL + field.corner[0], y * CELL + field.corner[1], turn), score


@compiled()
def branch_and_bound(
    levels: Levels,
    place: Array,
    heading: float,
    points: Array,
    half: Whole,
    step: float,
    turns: int,
    inverse_sd: Array,
    least: float,
) -> tuple[tuple[float, float, float], float]:
    """Search a window; lengths are in cells from the field's corner.

    Args:
        levels: (l, h, w) the field.
        place: (2,) the window's middle, and ``heading`` [rad].
        points: (n, 2) of the scan.
        half: (2,) how far the window reaches from its middle, whole cells.
        step: between headings [rad]; ``turns`` of them are tried to either side.
        inverse_sd: (3,) of the supposed pose, by cell, cell and step.
        least: score that has to be exceeded, and which is returned if none does.
    """
    top = len(levels) - 1
    side = 2**top
    across, up = int(2 * half[0] // side) + 1, int(2 * half[1] // side) + 1
    cells = np.empty((2 * turns + 1, len(points), 2), np.int32)
    bounds = np.empty(len(cells) * across * up, np.float32)
    for turn in range(-turns, turns + 1):
        own, first = cells[turn + turns], (turn + turns) * across * up
        _placed(points, place, heading + turn * step, own)
        for k in range(across * up):
            x, y = (k // up) * side - half[0], (k % up) * side - half[1]
            bounds[first + k] = _bound(levels[top], own, x, y, side, turn, inverse_sd)
    best, score = (place[0], place[1], heading), least
    stack = np.empty((STACK, 3), np.int64)
    waiting = np.empty(STACK)
    for first in np.argsort(-bounds):
        if bounds[first] <= score:
            break
        turn = first // (across * up) - turns
        rest = first % (across * up)
        own = cells[turn + turns]
        size = 1
        stack[0] = top, (rest // up) * side - half[0], (rest % up) * side - half[1]
        waiting[0] = bounds[first]
        while size:
            size -= 1
            if waiting[size] <= score:
                continue
            level, x, y = stack[size]
            if level == 0:
                score = waiting[size]
                best = place[0] + x, place[1] + y, heading + turn * step
                continue
            size = _branch(
                levels[level - 1], own, level - 1, x, y, half, turn, inverse_sd, score, stack,
                waiting, size,
            )  # fmt: skip
    return best, score


@compiled()
def _branch(
    field: Levels,
    cells: Whole,
    level: int,
    x: int,
    y: int,
    half: Whole,
    turn: int,
    inverse_sd: Array,
    score: float,
    stack: Whole,
    waiting: Array,
    size: int,
) -> int:
    """Put the four quarters of a square on the stack, the best last; return its new size."""
    side, begin = 2**level, size
    for i in range(2):
        for k in range(2):
            left, low = x + i * side, y + k * side
            if left > half[0] or low > half[1]:
                continue
            bound = _bound(field, cells, left, low, side, turn, inverse_sd)
            if bound <= score:
                continue
            slot = size
            while slot > begin and waiting[slot - 1] > bound:
                stack[slot], waiting[slot] = stack[slot - 1], waiting[slot - 1]
                slot -= 1
            stack[slot] = level, left, low
            waiting[slot] = bound
            size += 1
    return size


@compiled()
def _placed(points: Array, place: Array, heading: float, cells: Whole) -> None:
    c, s = math.cos(heading), math.sin(heading)
    for i in range(len(points)):
        cells[i, 0] = math.floor(place[0] + c * points[i, 0] - s * points[i, 1])
        cells[i, 1] = math.floor(place[1] + s * points[i, 0] + c * points[i, 1])


@compiled()
def _bound(
    field: Levels,
    cells: Whole,
    x: int,
    y: int,
    side: int,
    turn: int,
    inverse_sd: Array,
) -> float:
    """Return how well points fit at most, moved to a square's corner or less than a side
    farther."""
    total = 0.0
    for i in range(len(cells)):
        row, column = cells[i, 1] + y, cells[i, 0] + x
        if 0 <= row < field.shape[0] and 0 <= column < field.shape[1]:
            total += field[row, column]
    off_x = max(0, x, -(x + side - 1)) * inverse_sd[0]
    off_y = max(0, y, -(y + side - 1)) * inverse_sd[1]
    off_turn = turn * inverse_sd[2]
    prior = 0.5 * PRIOR * (off_x * off_x + off_y * off_y + off_turn * off_turn)
    return float(total / len(cells) - prior)
