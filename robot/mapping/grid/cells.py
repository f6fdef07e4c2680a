"""Occupancy grids of all particles: how a scan changes them, and how well it fits them."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from robot.compiling import compiled
from robot.geometry import Array

Grids = NDArray[np.float32]

FREE, TAKEN, MOST = -0.4, 0.85, 4.0
"""Log odds that a beam adds to a cell that it runs through, to one that it meets, and the largest
that a cell may have: later beams can still change it (Probabilistic Robotics, Table 9.1)."""
NEIGHBOURS = 1
"""What a beam met is searched for in this many cells to each side of its end."""
FEWEST_ENDS = 3
"""Fewest ends of beams that tell a wall's direction."""
RANDOM = 0.05
"""Share of beams that meet anything, such as people: none counts more than that against a pose."""


@compiled()
def updated_occupancy_grid(
    odds: Grids,
    ends: Grids,
    corner: Array,
    cell: float,
    pose: Array,
    begin: Array,
    end: Array,
    beyond: Array,
    hit: NDArray[np.bool_],
) -> None:
    """Write what beams tell from a pose into one particle's map (Table 9.1).

    Args:
        odds: (h, w) log odds that a cell is occupied.
        ends: (h, w, 6) number of beams that ended in a cell, the sums of where in it [m], and of
            the squares and products of that.
        corner: (2,) of the first cell [m].
        cell: side of a cell [m].
        pose: (3,) of the robot.
        begin: (n, 2) where beams begin, in the robot's frame [m].
        end: (n, 2) until where they are free [m].
        beyond: (n, 2) until where there is what they met [m].
        hit: (n,) which of them met something.
    """
    c, s = math.cos(pose[2]), math.sin(pose[2])
    for i in range(len(end)):
        x0, y0 = _placed(begin[i], pose, c, s, corner)
        x1, y1 = _placed(end[i], pose, c, s, corner)
        length = math.hypot(x1 - x0, y1 - y0)
        _add_line(odds, x0, y0, x1, y1, length - cell if hit[i] else length, cell, FREE)
        if not hit[i]:
            continue
        x2, y2 = _placed(beyond[i], pose, c, s, corner)
        _add_line(odds, x1, y1, x2, y2, math.hypot(x2 - x1, y2 - y1), cell, TAKEN)
        row, column = int(math.floor(y1 / cell)), int(math.floor(x1 / cell))
        if 0 <= row < odds.shape[0] and 0 <= column < odds.shape[1]:
            ends[row, column, 0] += 1
            dx, dy = x1 - column * cell, y1 - row * cell
            ends[row, column, 1] += dx
            ends[row, column, 2] += dy
            ends[row, column, 3] += dx * dx
            ends[row, column, 4] += dx * dy
            ends[row, column, 5] += dy * dy


@compiled()
def measurement_model_map(
    odds: Grids, ends: Grids, corner: Array, cell: float, pose: Array, met: Array, sd: float
) -> float:
    """Return the log-likelihood of a scan from a pose in one particle's map.

    The likelihood field (Table 6.3), with the distance to where earlier beams ended nearby.

    Args:
        odds: (h, w) as for ``updated_occupancy_grid``.
        ends: (h, w, 6)
        corner: (2,) [m]
        cell: [m]
        pose: (3,) of the robot.
        met: (n, 2) ends of beams that met something, in the robot's frame [m].
        sd: standard deviation of a beam's end [m].
    """
    c, s = math.cos(pose[2]), math.sin(pose[2])
    total = 0.0
    for i in range(len(met)):
        x, y = _placed(met[i], pose, c, s, corner)
        fit = math.exp(-_square(odds, ends, cell, x, y, sd) / 2)
        total += math.log((1 - RANDOM) * fit + RANDOM)
    return total


@compiled()
def known_ends(
    odds: Grids, corner: Array, cell: float, pose: Array, met: Array
) -> NDArray[np.bool_]:
    """Return which ends of beams (n, 2) lie where earlier beams have looked (n,).

    Elsewhere the map tells nothing of them; a pose must not gain by leading them there.
    """
    c, s = math.cos(pose[2]), math.sin(pose[2])
    known = np.zeros(len(met), np.bool_)
    for i in range(len(met)):
        x, y = _placed(met[i], pose, c, s, corner)
        row, column = int(math.floor(y / cell)), int(math.floor(x / cell))
        for r in range(max(0, row - 1), min(odds.shape[0], row + 2)):
            for k in range(max(0, column - 1), min(odds.shape[1], column + 2)):
                known[i] |= odds[r, k] != 0
    return known


@compiled()
def _square(odds: Grids, ends: Grids, cell: float, x: float, y: float, sd: float) -> float:
    """Return the squared distance of a beam's end from where others ended, in deviations.

    Those nearby are described by their mean and covariance (normal distributions transform), so
    that along a wall an end may lie anywhere.
    """
    row, column = int(math.floor(y / cell)), int(math.floor(x / cell))
    n = mx = my = xx = xy = yy = 0.0
    for r in range(max(0, row - NEIGHBOURS), min(odds.shape[0], row + NEIGHBOURS + 1)):
        for k in range(max(0, column - NEIGHBOURS), min(odds.shape[1], column + NEIGHBOURS + 1)):
            if ends[r, k, 0] == 0 or odds[r, k] <= 0:
                continue
            # From the point, as sums of squares of large numbers would be inexact.
            dx, dy = k * cell - x, r * cell - y
            count, sx, sy = ends[r, k, 0], ends[r, k, 1], ends[r, k, 2]
            n += count
            mx += sx + count * dx
            my += sy + count * dy
            xx += ends[r, k, 3] + 2 * dx * sx + count * dx * dx
            xy += ends[r, k, 4] + dx * sy + dy * sx + count * dx * dy
            yy += ends[r, k, 5] + 2 * dy * sy + count * dy * dy
    if n < FEWEST_ENDS:
        return np.inf
    mx, my = mx / n, my / n
    xx, xy, yy = xx / n - mx * mx + sd * sd, xy / n - mx * my, yy / n - my * my + sd * sd
    return float((yy * mx * mx - 2 * xy * mx * my + xx * my * my) / (xx * yy - xy * xy))


@compiled(inline="always")
def _placed(point: Array, pose: Array, c: float, s: float, corner: Array) -> tuple[float, float]:
    """Return a point of the robot's frame from the grid's corner [m]."""
    x = pose[0] + c * point[0] - s * point[1] - corner[0]
    y = pose[1] + s * point[0] + c * point[1] - corner[1]
    return x, y


@compiled()
def _add_line(
    odds: Grids, x0: float, y0: float, x1: float, y1: float, until: float, cell: float, more: float
) -> None:
    """Add log odds to the cells on a line, until a distance from its start [m]."""
    length = math.hypot(x1 - x0, y1 - y0)
    last_row = last_column = -1
    for part in range(int(2 * until / cell) + 1):
        share = 0.5 * part * cell / max(length, 1e-9)
        row = int(math.floor((y0 + share * (y1 - y0)) / cell))
        column = int(math.floor((x0 + share * (x1 - x0)) / cell))
        if row == last_row and column == last_column:
            continue
        last_row, last_column = row, column
        if 0 <= row < odds.shape[0] and 0 <= column < odds.shape[1]:
            odds[row, column] = min(MOST, max(-MOST, odds[row, column] + more))
