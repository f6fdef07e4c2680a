"""Likelihood field with beam skipping: rays that hardly any particle explains do not count."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from robot.compiling import compiled
from robot.geometry import Array, heading_angles, heading_vectors
from robot.localization.kernels.entry_planes import DIRECTIONS
from robot.localization.models.likelihood_field import LikelihoodField
from robot.scan import Scan, evenly

ASKED = 500
"""Particles by which a share is estimated, to two per cent; they are chosen evenly."""


@dataclass(frozen=True)
class LikelihoodFieldProb:
    """Likelihood field (Table 6.3) that skips rays, like nav2's model of the same name.

    A ray agrees with a particle if it ends less than ``skip_distance`` from an edge. If it agrees
    with at most a share ``skip_threshold`` of the particles, it is skipped, because something
    stands there that is not in the map. If a share ``skip_error_threshold`` of the rays would be
    skipped, the particles are wrong, and all rays count. While the cloud is wider than
    ``skip_distance``, no ray is skipped, because good rays agree with few particles then (nav2:
    while the filter has not converged).
    """

    plain: LikelihoodField
    skips: bool
    skip_distance: float
    """[m]"""
    skip_threshold: float
    skip_error_threshold: float

    def log_likelihood(self, poses: Array, scan: Scan) -> Array:
        """Return the log-likelihood (n,) of a scan at poses (n, 3), up to a constant."""
        return self.plain.log_likelihood(poses, self.without_skipped(poses, scan))

    def count_rays(self, poses: Array, scan: Scan) -> int:
        """Return how many rays the log-likelihood is the sum of; skipped rays do not count."""
        return self.plain.count_rays(poses, self.without_skipped(poses, scan))

    def without_skipped(self, poses: Array, scan: Scan) -> Scan:
        """Return a scan without the rays that hardly any of the poses (n, 3) explains."""
        if not (self.skips and len(poses) and scan.hit.any()):
            return scan
        poses = poses[evenly(len(poses), ASKED)]
        scan = scan.only(self.plain.counted(scan))
        points = scan.points()
        if _width(poses, points) >= self.skip_distance:
            return scan
        kept = self._agreeing(poses, points, scan) > self.skip_threshold
        if np.mean(~kept) >= self.skip_error_threshold:
            return scan
        # A likelihood field ignores rays without a return.
        return replace(scan, ranges=np.where(kept, scan.ranges, np.inf))

    def _agreeing(self, poses: Array, points: Array, scan: Scan) -> Array:
        """Return the share (k,) of the poses that each ray agrees with."""
        directions = scan.robot_from_scan.theta + scan.bearings
        field = self.plain.field
        return _agreeing(
            poses,
            points,
            directions * (DIRECTIONS / (2 * math.pi)),
            field.distances,
            field.origin,
            field.resolution,
            self.skip_distance,
        )


def _width(poses: Array, points: Array) -> float:
    """Return the standard deviation of a typical ray's end over the particles [m]."""
    toward = heading_vectors(poses[:, 2])
    middle = heading_angles(toward.mean(axis=0))
    turned = np.sqrt(np.mean(np.square(2 * np.sin((poses[:, 2] - middle) / 2))))
    reach = np.median(np.hypot(points[:, 0], points[:, 1]))
    return math.hypot(*poses[:, :2].std(axis=0), turned * reach)


@compiled(error_model="numpy")
def _agreeing(
    poses: Array,
    points: Array,
    turns: Array,
    distances: NDArray[np.float32],
    origin: tuple[float, float],
    resolution: float,
    skip_distance: float,
) -> Array:
    agreeing = np.zeros(len(points))
    for i in range(len(poses)):
        c, s = math.cos(poses[i, 2]), math.sin(poses[i, 2])
        turn = poses[i, 2] * (DIRECTIONS / (2 * math.pi)) + 0.5
        for j in range(len(points)):
            u = (poses[i, 0] + c * points[j, 0] - s * points[j, 1] - origin[0]) / resolution
            v = (poses[i, 1] + s * points[j, 0] + c * points[j, 1] - origin[1]) / resolution
            if _distance(u, v, turn + turns[j], distances, 1.5 * resolution) < skip_distance:
                agreeing[j] += 1
    return agreeing / len(poses)


@compiled(forceinline=True)
def _distance(
    u: float, v: float, turn: float, distances: NDArray[np.float32], jump: float
) -> float:
    """Return the distance [m] from a place (in cells) to an edge that a ray there can meet.

    It is +inf outside the table.
    """
    directions, height, width = distances.shape
    if not (0.0 <= u < width - 1.0 and 0.0 <= v < height - 1.0):
        return math.inf
    column, row = int(u), int(v)
    facing = int(math.floor(turn)) % directions
    du, dv = u - column, v - row
    near, far = distances[facing, row], distances[facing, row + 1]
    d00, d01, d10, d11 = near[column], near[column + 1], far[column], far[column + 1]
    # If corners differ by more than their distance, no edge is between them: the sign ends there.
    if max(d00, d01, d10, d11) - min(d00, d01, d10, d11) > jump:
        d00, d01, d10, d11 = abs(d00), abs(d01), abs(d10), abs(d11)
    return float(abs((1 - dv) * ((1 - du) * d00 + du * d01) + dv * ((1 - du) * d10 + du * d11)))
