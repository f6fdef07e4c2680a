"""Prediction on a grid: probability goes from box to box as the robot moves."""

from __future__ import annotations

import math

import numpy as np

from robot.compiling import compiled
from robot.geometry import Array, Pose2, heading_vectors
from robot.localization.grid.pose_grid import (
    FEWEST_TURNS,
    Boxes,
    Indices,
    PoseGrid,
    add_box,
    no_boxes,
)

PASS = 0.5
"""Variance that one pass spreads, in boxes squared; three boxes can hold at most 0.75."""
MOST_PASSES = 4
"""A step that would need more passes makes the boxes coarser."""


def moved_grid(grid: PoseGrid, step: Pose2, noise: Array) -> PoseGrid:
    """Return a belief after a step (Probabilistic Robotics, Table 4.1, line 3).

    Boxes are fixed on the map. Shares of each box go to the three boxes nearest to its end, along
    x, y and theta. So mean and variance are right even for steps shorter than a box, with two
    limits: an end d boxes from a middle has at least the variance d (1 - d), so a step should err
    by about half a box; and the errors of x, y and theta are independent.

    Args:
        grid: the belief; it gets coarser where the step errs by more than the boxes are wide.
            Headings that err by more than the widest boxes can take are mixed with even ones.
        step: the step, seen from its start.
        noise: (3, 3) covariance [m, m, rad] of its end, seen from its start.
    """
    variances = _variances(grid.boxes, noise)
    known = 1.0
    if grid.boxes.turns == FEWEST_TURNS:
        # Boxes of heading get no wider than that; the rest of the noise makes all headings likely.
        taken = np.minimum(variances[0, 2], PASS * MOST_PASSES)
        known = math.exp(-(variances[0, 2] - taken) * grid.boxes.size[2] ** 2 / 2)
        variances[:, 2] = taken
    passes = max(1, math.ceil(variances.max() / PASS))
    if passes > MOST_PASSES:
        return moved_grid(grid.coarser(), step, noise)
    shifts = _shifts(grid.boxes, step)
    still = np.zeros_like(shifts)
    # The pass that takes the step blurs by it: the others spread what is left. Those of x and y
    # come before it, by the heading that the step began with.
    with_step = np.maximum(variances / passes, np.minimum(variances, _blur(shifts)))
    left = (variances - with_step) / max(1, passes - 1)
    for _ in range(passes - 1):
        grid = _spread(grid, still, left * (1, 1, 0))
    grid = _spread(grid, shifts, with_step)
    for _ in range(passes - 1):
        grid = _spread(grid, still, left * (0, 0, 1))
    return grid if known == 1.0 else _partly_turned(grid, known)


def _partly_turned(grid: PoseGrid, known: float) -> PoseGrid:
    """Return a belief of which a share keeps its heading; the rest gets any heading.

    Noise with the variance v shortens the mean direction vector to exp(-v / 2).
    """
    turns = grid.boxes.turns
    everywhere = np.repeat(grid.cells, turns, axis=0)
    everywhere[:, 2] = np.tile(np.arange(turns), len(grid.cells))
    evenly = np.repeat(grid.mass * ((1 - known) / turns), turns)
    cells = np.concatenate([grid.cells, everywhere])
    return PoseGrid.of(grid.boxes, cells, np.concatenate([known * grid.mass, evenly]))


def _headings(boxes: Boxes) -> Array:
    """Return unit vectors (turns, 2) along the middle headings of the boxes."""
    return heading_vectors((np.arange(boxes.turns) + 0.5) * boxes.size[2] - math.pi)


def _shifts(boxes: Boxes, step: Pose2) -> Array:
    """Return how far a step moves boxes of each heading (turns, 3), in boxes."""
    ahead = _headings(boxes)
    shifts = np.full((boxes.turns, 3), step.theta)
    shifts[:, :2] = step.x * ahead + step.y * ahead[:, ::-1] * (-1, 1)
    shifts /= boxes.size
    return shifts


def _variances(boxes: Boxes, noise: Array) -> Array:
    """Return the variance (turns, 3) of the end along x, y and theta, by heading, in boxes."""
    c, s = _headings(boxes).T
    variances = np.full((boxes.turns, 3), noise[2, 2])
    variances[:, 0] = c * c * noise[0, 0] - 2 * c * s * noise[0, 1] + s * s * noise[1, 1]
    variances[:, 1] = s * s * noise[0, 0] + 2 * c * s * noise[0, 1] + c * c * noise[1, 1]
    variances /= np.square(boxes.size)
    return variances


def _blur(shifts: Array) -> Array:
    """Return the least variance of shares whose mean lies between the middles of boxes."""
    offset = np.abs(shifts - np.rint(shifts))
    least: Array = offset * (1 - offset)
    return least


def _spread(grid: PoseGrid, shifts: Array, variances: Array) -> PoseGrid:
    """Spread each box to its neighbours; shifts and variances (turns, 3) are in boxes."""
    nearest = np.rint(shifts)
    offset = shifts - nearest
    square = np.maximum(variances, _blur(shifts)) + offset * offset
    # Shares of the three with the sum 1, the mean ``off`` and the mean square ``square``.
    shares = np.stack([(square - offset) / 2, 1 - square, (square + offset) / 2], axis=-1)
    cells, mass = grid.cells, grid.mass
    # The heading comes last, because x and y depend on the heading before the step.
    for axis in range(3):
        columns = nearest[:, axis].astype(np.int64)
        cells, mass = _share(cells, mass, axis, columns, shares[:, axis])
    return PoseGrid(grid.boxes, cells, mass / mass.sum())


@compiled()
def _share(
    cells: Indices, mass: Array, axis: int, nearest: Indices, shares: Array
) -> tuple[Indices, Array]:
    """Move the mass of boxes (n, 3) along an axis, to three boxes each.

    Args:
        cells: the boxes.
        mass: mass of each box.
        axis: the axis to move along.
        nearest: (turns,) distance to the middle one of the three boxes, by heading, in boxes.
        shares: (turns, 3) share of each of the three boxes.
    """
    turns = len(nearest)
    table, merged, total = no_boxes(3 * len(cells))
    result = 0
    for i in range(len(cells)):
        turn = cells[i, 2]
        x, y, t = cells[i, 0], cells[i, 1], turn
        for k in range(3):
            target = nearest[turn] + k - 1
            if axis == 0:
                x = cells[i, 0] + target
            elif axis == 1:
                y = cells[i, 1] + target
            else:
                t = (turn + target) % turns
            result = add_box(x, y, t, mass[i] * shares[turn, k], table, merged, total, result)
    return merged[:result].copy(), total[:result].copy()
