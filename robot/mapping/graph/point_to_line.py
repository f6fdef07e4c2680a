"""Lays a scan on another one: iterative closest points, measured across the surfaces they lie on.

As in PL-ICP (Censi 2008) and generalized ICP (Segal, Haehnel and Thrun 2009): along a wall, a point
may lie anywhere, so a corridor tells nothing of how far along it the robot is.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from robot.compiling import compiled
from robot.geometry import Array, Pose2
from robot.mapping.graph.surfaces import Surfaces

STEPS = 20
"""Most Gauss-Newton steps."""
SD = 0.03
"""Standard deviation of a point from the other scan's surface [m]."""
LOOSE_SD = 0.15
"""... and from the nearest point, where nothing tells a surface's direction [m]."""
FACING = 0.7
"""Least cosine between the normals of points that are of one surface."""
TEMPER = 0.125
"""Share of the information that is believed: neighbouring beams err alike, and corridors are
not straight to the millimetre."""
FLOOR = np.diag(np.square([0.007, 0.007, 0.003]))
"""Covariance (3, 3) that no match is below [m, m, rad]."""


class ScanAlignment(NamedTuple):
    """Where a scan lies on another one."""

    pose: Pose2
    """Of the scan, in the other's frame."""
    information: Array
    """(3, 3) inverse of its covariance; singular where the surfaces do not tell [m, m, rad]."""
    share: float
    """Of the points that could be seen in the other scan, those that lie on its surfaces."""
    fitting: int
    """Number of them."""


def match_scans(scan: Surfaces, other: Surfaces, pose: Pose2, gate: float) -> ScanAlignment:
    """Move a scan to where it lies on another one.

    Args:
        scan: what is moved.
        other: what it is laid on.
        pose: a supposed pose of the scan in the other's frame.
        gate: largest distance of a point from the other's [m]; it narrows with each step.
    """
    fitted, information, fitting, near = fit_points(*scan[:2], *other[:3], pose.to_array(), gate)
    information = TEMPER * _clipped(information)
    believed = np.linalg.solve(np.eye(3) + information @ FLOOR, information)
    share = fitting / max(near, 1)
    return ScanAlignment(Pose2(*fitted.tolist()), (believed + believed.T) / 2, share, fitting)


def _clipped(information: Array) -> Array:
    """Return the nearest matrix (3, 3) without negative eigenvalues."""
    values, axes = np.linalg.eigh(information)
    clipped: Array = axes * np.maximum(values, 0.0) @ axes.T
    return clipped


@compiled()
def fit_points(
    points: Array,
    normals: Array,
    targets: Array,
    target_normals: Array,
    spread: Array,
    start: Array,
    gate: float,
) -> tuple[Array, Array, int, int]:
    """Lay points on others by Gauss-Newton steps.

    Args:
        points: (n, 2) [m].
        normals: (n, 2) of their surfaces, or zeros.
        targets: (m, 2) the other points [m].
        target_normals: (m, 2)
        spread: (m,) variance of those [rad²].
        start: (3,) the supposed pose of the points' frame in the others'.
        gate: largest distance of points that belong together [m].

    Returns:
        The pose (3,) that fits, its information (3, 3), how many points fit, and how many lie
        anywhere near others.
    """
    pose, reach = start.copy(), gate
    narrow = min(gate, 5 * SD)
    total, pull = np.zeros((3, 3)), np.zeros(3)
    for _ in range(STEPS):
        equations(points, normals, targets, target_normals, spread, pose, reach, total, pull)
        step = np.linalg.solve(total + 1.0 * np.eye(3), pull)
        pose = pose + step
        small = abs(step[0]) + abs(step[1]) + abs(step[2]) < 1e-4
        if small and reach <= narrow:
            break
        reach = max(narrow, 0.7 * reach)
    fitting, near = equations(
        points, normals, targets, target_normals, spread, pose, narrow, total, pull, True
    )
    pose[2] = (pose[2] + math.pi) % (2 * math.pi) - math.pi
    return pose, total, fitting, near


@compiled()
def equations(
    points: Array,
    normals: Array,
    targets: Array,
    target_normals: Array,
    spread: Array,
    pose: Array,
    reach: float,
    total: Array,
    pull: Array,
    unbiased: bool = False,
) -> tuple[int, int]:
    """Write J^T W J and J^T W r into ``total`` and ``pull``.

    Return how many points fit, and how many lie within sight of others. A normal that errs by an
    angle looks as if it told something along its surface; ``unbiased`` takes that off again.
    """
    total[:], pull[:] = 0.0, 0.0
    c, s = math.cos(pose[2]), math.sin(pose[2])
    fitting = near = 0
    J, W = np.empty((2, 3)), np.empty((2, 2))
    for i in range(len(points)):
        turned_x = c * points[i, 0] - s * points[i, 1]
        turned_y = s * points[i, 0] + c * points[i, 1]
        x, y = pose[0] + turned_x, pose[1] + turned_y
        facing_x = c * normals[i, 0] - s * normals[i, 1]
        facing_y = s * normals[i, 0] + c * normals[i, 1]
        k, best = _nearest(x, y, facing_x, facing_y, targets, target_normals)
        if k < 0:
            continue
        dx, dy = targets[k, 0] - x, targets[k, 1] - y
        nx, ny = target_normals[k, 0], target_normals[k, 1]
        wall = spread[k] < np.inf
        # Along a surface points are as far apart as its beams are.
        across = abs(nx * dx + ny * dy) if wall else math.sqrt(best)
        if math.sqrt(best) > max(reach, 0.5):
            continue
        near += 1
        if across > reach:
            continue
        fitting += 1
        _weigh(nx, ny, across, spread[k] if unbiased or not wall else 0.0, W)
        J[0, 0], J[0, 1], J[0, 2] = 1.0, 0.0, -turned_y
        J[1, 0], J[1, 1], J[1, 2] = 0.0, 1.0, turned_x
        rx, ry = W[0, 0] * dx + W[0, 1] * dy, W[1, 0] * dx + W[1, 1] * dy
        for a in range(3):
            wa = W[0, 0] * J[0, a] + W[0, 1] * J[1, a], W[1, 0] * J[0, a] + W[1, 1] * J[1, a]
            pull[a] += J[0, a] * rx + J[1, a] * ry
            for b in range(3):
                total[a, b] += wa[0] * J[0, b] + wa[1] * J[1, b]
    return fitting, near


@compiled(inline="always")
def _weigh(nx: float, ny: float, distance: float, spread: float, W: Array) -> None:
    """Write the information (2, 2) of a point: across a surface, or around another point.

    Those that are far from it count less (Cauchy's weights).
    """
    if spread == np.inf:
        W[0, 0] = W[1, 1] = 1 / (LOOSE_SD * LOOSE_SD + distance * distance / 4)
        W[0, 1] = W[1, 0] = 0.0
        return
    weight = 1 / (SD * SD + distance * distance / 4)
    W[0, 0] = weight * (nx * nx - spread * ny * ny)
    W[1, 1] = weight * (ny * ny - spread * nx * nx)
    W[0, 1] = W[1, 0] = weight * (1 + spread) * nx * ny


@compiled()
def _nearest(
    x: float, y: float, facing_x: float, facing_y: float, targets: Array, normals: Array
) -> tuple[int, float]:
    """Return the nearest point that faces the same way, and the square of its distance [m²].

    It is -1 if there is none. A point whose surface has no direction may be of any.
    """
    loose = facing_x == 0 and facing_y == 0
    best, k = np.inf, -1
    for m in range(len(targets)):
        dx, dy = targets[m, 0] - x, targets[m, 1] - y
        square = dx * dx + dy * dy
        if square < best:
            nx, ny = normals[m, 0], normals[m, 1]
            if loose or (nx == 0 and ny == 0) or facing_x * nx + facing_y * ny > FACING:
                best, k = square, m
    return k, best
