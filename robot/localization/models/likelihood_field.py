"""Likelihood field: a scan fits a pose when its ends lie on edges of the map."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from robot.geometry import Array
from robot.localization.models.entry_field import DIRECTIONS, EntryField
from robot.scan import Scan, evenly


@dataclass(frozen=True)
class LikelihoodField:
    """Likelihood field for range finders (Probabilistic Robotics, Table 6.3), by direction.

    p = z_hit exp(-d^2 / 2 sigma_hit^2) + z_rand / range_max for each ray that returned, with d the
    distance of its end from the nearest edge that it can meet. Rays without a return say nothing.
    """

    field: EntryField
    sigma_hit: float
    """Standard deviation of a range [m]."""
    z_hit: float
    z_rand: float
    range_max: float
    """[m]"""
    max_beams: int
    """Rays used of a scan, evenly spread over those that returned."""

    def log_likelihood(self, poses: Array, scan: Scan) -> Array:
        """Log-likelihood (n,) of a scan at poses (n, 3), up to a constant."""
        points = scan.points()
        directions = scan.robot_from_scan.theta + scan.bearings[scan.hit]
        used = evenly(len(points), self.max_beams)
        points, directions = points[used], directions[used]
        turns = directions * (DIRECTIONS / (2 * math.pi))
        result = np.zeros(len(poses))
        _add_log_likelihoods(
            poses,
            points,
            turns,
            self.field.distances,
            self.field.origin,
            self.field.resolution,
            self.field.max_distance,
            self._table(scan.extra_sd),
            result,
        )
        return result

    def _table(self, extra_sd: float) -> NDArray[np.float32]:
        """Log-likelihood by distance, in even steps up to the greatest."""
        d = np.linspace(0, self.field.max_distance, 2048)
        variance = self.sigma_hit**2 + extra_sd**2
        p = self.z_hit * np.exp(-0.5 * np.square(d) / variance) + self.z_rand / self.range_max
        return np.log(p).astype(np.float32)


@njit(cache=True, nogil=True, fastmath=True)
def _add_log_likelihoods(
    poses: Array,
    points: Array,
    turns: Array,
    distances: NDArray[np.float32],
    origin: tuple[float, float],
    resolution: float,
    max_distance: float,
    table: NDArray[np.float32],
    result: Array,
) -> None:
    directions, height, width = distances.shape
    scale = 1.0 / resolution
    farthest = len(table) - 1
    # The last table entry is the greatest distance, which is also what lies outside the field.
    step = farthest / max_distance
    # A distance changes by no more than the way, so a cell with corners that differ by more is one
    # where the sign ends and not an edge: there interpolation would pass through zero.
    jump = 1.5 * resolution
    for i in range(len(poses)):
        x, y, theta = poses[i]
        c, s = math.cos(theta), math.sin(theta)
        turn = theta * (directions / (2 * math.pi))
        total = 0.0
        for j in range(len(points)):
            px, py = points[j]
            u = (x + c * px - s * py - origin[0]) * scale
            v = (y + s * px + c * py - origin[1]) * scale
            column, row = int(math.floor(u)), int(math.floor(v))
            if 0 <= column < width - 1 and 0 <= row < height - 1:
                facing = int(math.floor(turn + turns[j] + 0.5)) % directions
                du, dv = u - column, v - row
                near, far = distances[facing, row], distances[facing, row + 1]
                d00, d01 = near[column], near[column + 1]
                d10, d11 = far[column], far[column + 1]
                if max(d00, d01, d10, d11) - min(d00, d01, d10, d11) > jump:
                    d00, d01, d10, d11 = abs(d00), abs(d01), abs(d10), abs(d11)
                d = (1 - dv) * ((1 - du) * d00 + du * d01) + dv * ((1 - du) * d10 + du * d11)
                total += table[min(int(abs(d) * step + 0.5), farthest)]
            else:
                total += table[farthest]
        result[i] = total
