"""Finds where on the field a drive may have begun, by the edges that its first seconds saw."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from robot.calibration.sightings import FloorPoints
from robot.fields.field import Field
from robot.geometry import Array, Pose2
from robot.localization.hypotheses.coarse_grid import Cheapest, CoarseGrid, cost_at
from robot.localization.models.entry_field import EntryField

SECONDS = 3.0
"""How much of the drive is laid on the field [s]: for longer, the wheels are not known."""
MOST_EDGES = 250
"""Edges that are laid on the field."""
STEP, TURN = 0.04, math.radians(5)
"""Steps of the poses that are tried [m, rad]."""
BLUR, FARTHEST, CELL = 0.03, 0.2, 0.01
"""Distance from an edge that costs one half, the largest that is told from others, and the size of
the table's cells [m]."""
MOST_MINIMA, MOST_STARTS = 60, 5
"""Most poses that are refined, and most of them that are returned as starts."""
APART, TURNED = 0.08, math.radians(12)
"""Poses nearer to each other than this are one [m, rad]."""
NEAR_STEP, NEAR_TURN = 0.03, math.radians(4)
"""Largest steps of the poses that are tried near a pose [m, rad]."""
EDGE_WEIGHT, WORST = 0.2, 0.35
"""Weight of an edge's cost beside what the wheels tell: neighbours see the same; and the largest
mean cost of edges that are laid on the field."""
WORSE = 0.12
"""Share of the edges by whose cost a start may be worse than the best."""


def entry_table(taped: Field) -> EntryField:
    """Return the table in which edges are laid on a field."""
    return EntryField.build(taped, resolution=CELL, max_distance=FARTHEST)


def start_poses(
    floor: FloorPoints, steps: Array, taped: Field, entries: EntryField, given_pose: Pose2
) -> list[Pose2]:
    """Return where the drive may have begun, the likeliest pose first.

    Of poses that look alike, as the field is symmetric, only the one nearest the given pose is
    returned.

    Args:
        floor: the edges that the first pictures saw.
        steps: (k - 1, 3) how the robot moved from each picture to the next [m, m, rad].
        taped: the field.
        entries: of ``entry_table``.
        given_pose: where the robot was, as told.
    """
    ends = edge_ends(floor, steps)
    if not len(ends):
        return []
    grid = CoarseGrid.over(taped.drive_area, STEP, TURN)
    costs = np.empty(grid.shape, np.float32)
    grid.score(slice(None), ends, entries, BLUR, costs)
    limit = float(costs.min()) + 2 * WORSE * len(ends)
    cheapest = Cheapest(MOST_MINIMA, limit)
    cheapest.look(costs, slice(None))
    poses = grid.refined_poses(grid.poses(cheapest.cells), ends, entries, BLUR)
    exact = costs_at(poses, ends, entries, BLUR)
    order = np.argsort(exact, kind="stable")
    likely = order[exact[order] < exact.min() + WORSE * len(ends)]
    distinct: list[Pose2] = []
    for pose in (Pose2(*poses[place].tolist()) for place in likely):
        images = [image @ pose for image in (Pose2(), *taped.symmetries)]
        if not any(alike(image, other) for image in images for other in distinct):
            distinct.append(min(images, key=lambda image: _away(image, given_pose)))
    return distinct[:MOST_STARTS]


def alike(a: Pose2, b: Pose2) -> bool:
    """Whether two poses are one."""
    return a.distance_to(b) < APART and abs(a.turn_to(b)) < TURNED


def _away(a: Pose2, b: Pose2) -> float:
    return math.hypot(a.distance_to(b) / APART, a.turn_to(b) / TURNED)


def edge_ends(floor: FloorPoints, steps: Array) -> Array:
    """Return where rays entered tape [m], and their directions [rad] (n, 3), from the first pose.

    Args:
        floor: the edges that some pictures saw.
        steps: (k - 1, 3) how the robot moved from each picture to the next [m, m, rad].
    """
    rays = floor.points.shape[1] // 2
    pose, ends = Pose2(), []
    for picture, points in enumerate(floor.points[:, :rays]):
        if picture > 0:
            pose = pose @ Pose2(*steps[picture - 1].tolist())
        seen = points[np.isfinite(points[:, 0])]
        directions = np.arctan2(seen[:, 1], seen[:, 0]) + pose.theta
        ends.append(np.column_stack([pose.apply(seen), directions]))
    every = np.concatenate(ends) if ends else np.empty((0, 3))
    return np.ascontiguousarray(every[:: max(1, len(every) // MOST_EDGES)])


def pose_near(pose: Array, covariance: Array, ends: Array, entries: EntryField) -> Array | None:
    """Return the pose (3,) near a pose at which the edges fit best; None if they fit nowhere.

    Args:
        pose: (3,) where the robot probably is [m, m, rad].
        covariance: (3, 3) of that.
        ends: (n, 3) of ``edge_ends``.
        entries: of ``entry_table``.
    """
    reach = 3 * np.sqrt(np.diag(covariance))
    counts = np.ceil(reach / (NEAR_STEP, NEAR_STEP, NEAR_TURN)).astype(int)
    steps = reach / counts
    information = np.linalg.inv(covariance)
    best = pose
    for halving in range(3):
        lattice = best + _lattice(steps / 2**halving, counts if halving == 0 else np.ones(3, int))
        away = lattice - pose
        unlikely = 0.5 * np.einsum("ni,ij,nj->n", away, information, away)
        costs = costs_at(lattice, ends, entries, BLUR)
        cheapest = int(np.argmin(unlikely + EDGE_WEIGHT * costs))
        best = lattice[cheapest]
    return best if costs[cheapest] < WORST * len(ends) else None


def costs_at(poses: Array, ends: Array, entries: EntryField, blur: float) -> Array:
    """Return the costs (n,) of poses (n, 3), as ``CoarseGrid.score`` has them."""
    table = entries.distances, entries.origin, entries.resolution
    return np.array([cost_at(pose, ends, *table, blur) for pose in poses])


def _lattice(steps: Array, counts: NDArray[np.int64]) -> Array:
    """Return the points (n, 3) around the origin that are at most a number of steps away."""
    axes = [step * np.arange(-count, count + 1) for step, count in zip(steps, counts, strict=True)]
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
