"""Likelihood field: a scan fits a pose when its ends lie on edges of the map."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numba import float32, int32, njit, uint32
from numpy.polynomial import Chebyshev, Polynomial
from numpy.typing import NDArray

from robot.geometry import Array
from robot.localization.headings import heading_vector
from robot.localization.models.entry_field import EntryField
from robot.localization.models.entry_planes import FARTHEST, STEEPEST, VALUE_SHIFT, X_SHIFT
from robot.scan import Scan

BATCH = 32
"""The compiler works on so many rays at a time; a scan is filled up with rays that say nothing."""

END = 8.0
_BEND = Chebyshev.interpolate(lambda t: np.log1p(np.exp(-t)), 8, [0.0, END])
B0, B1, B2, B3, B4, B5, B6, B7, B8 = (np.float32(c) for c in _BEND.convert(kind=Polynomial).coef)
"""log(1 + exp(-t)) from 0 to ``END``, to 7e-5; beyond, it is less than 4e-4."""


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
        start = scan.robot_from_scan
        rays, used = ray_ends(
            scan.bearings, scan.ranges, (start.x, start.y, start.theta), self.max_beams, BATCH
        )
        field = self.field
        precision = 0.5 / (self.sigma_hit**2 + scan.extra_sd**2)
        false = max(self.z_rand / self.range_max, 1e-30)
        peak = math.log(max(self.z_hit, 1e-30) / false)
        # What the sum holds of the rays that it was filled up with, which are as far as can be.
        spare = math.log1p(math.exp(peak - precision * field.max_distance**2))
        return _sums(
            poses,
            rays,
            field.planes,
            field.origin,
            field.resolution,
            field.max_distance,
            precision,
            peak,
            used * math.log(false) - (rays.shape[1] - used) * spare,
        )


@njit(cache=True, nogil=True)
def ray_ends(
    bearings: Array,
    ranges: Array,
    robot_from_scan: tuple[float, float, float],
    most: int,
    batch: int,
) -> tuple[NDArray[np.float32], int]:
    """x, y [m] and direction [rad] (3, k) in the robot frame of evenly spread rays that returned.

    Filled up to a multiple of ``batch`` with rays that end far away; also how many are real.
    """
    found = np.flatnonzero(np.isfinite(ranges))
    used = min(len(found), most)
    rays = np.zeros((3, (used + batch - 1) // batch * batch), dtype=np.float32)
    rays[:2] = FAR_AWAY
    x, y, theta = robot_from_scan
    step = (len(found) - 1) / max(used - 1, 1)
    for j in range(used):
        ray = found[int(j * step)]
        direction = theta + bearings[ray]
        rays[0, j] = x + ranges[ray] * math.cos(direction)
        rays[1, j] = y + ranges[ray] * math.sin(direction)
        rays[2, j] = direction
    return rays, used


FAR_AWAY = 1e5
"""Off any field [m]."""


@njit(cache=True, nogil=True, fastmath=True, error_model="numpy")
def _sums(
    poses: Array,
    rays: NDArray[np.float32],
    words: NDArray[np.int32],
    origin: tuple[float, float],
    resolution: float,
    max_distance: float,
    precision: float,
    peak: float,
    constant: float,
) -> Array:
    """A constant and the sum (n,) over rays of log(1 + exp(peak - d^2 precision)), by poses (n, 3).

    Compiled such that sixteen rays are worked on together, 1 ns each: no branch and no call in the
    inner loop, and one read of the table. What is not on the table is cut to its last row or
    column, which is far from everything.
    """
    directions, height, width = words.shape
    table = words.ravel()
    last_row, last_column = uint32(height - 1), uint32(width - 1)
    scale = 1.0 / resolution
    # Distances come in units of the word's value, squares of them in those of the exponent.
    slope = float32(resolution / STEEPEST * FARTHEST / max_distance / 2 ** (32 - 2 * X_SHIFT - 9))
    unit = float32(precision * (max_distance / FARTHEST / 2**VALUE_SHIFT) ** 2)
    top, end, none = float32(peak), float32(END), float32(0.0)
    headings = np.empty((2, len(poses)), dtype=np.float32)
    turns = rays[2] * float32(directions / (2 * math.pi))
    for i in range(len(poses)):
        cosine, sine = heading_vector(poses[i, 2])
        headings[0, i], headings[1, i] = float32(cosine * scale), float32(sine * scale)
    result = np.empty(len(poses))
    for i in range(len(poses)):
        x, y = (
            float32((poses[i, 0] - origin[0]) * scale),
            float32((poses[i, 1] - origin[1]) * scale),
        )
        c, s = headings[0, i], headings[1, i]
        turn = float32(poses[i, 2] * (directions / (2 * math.pi)) + 0.5 + 4 * directions)
        total = float32(0.0)
        for j in range(len(turns)):
            u = x + c * rays[0, j] - s * rays[1, j]
            v = y + s * rays[0, j] + c * rays[1, j]
            # Below zero is far above it without a sign.
            column = min(uint32(int32(u)), last_column)
            row = min(uint32(int32(v)), last_row)
            facing = uint32(int32(turn + turns[j])) & uint32(directions - 1)
            cell = uint32(uint32(facing * uint32(height) + row) * uint32(width) + column)
            word = table[cell & uint32(0x7FFFFFFF)]
            along_x = float32(int32(word << int32(14))) * (u - float32(int32(column)))
            along_y = float32(int32(word << int32(23))) * (v - float32(int32(row)))
            d = float32(word) + (along_x + along_y) * slope
            t = top - d * d * unit
            a = min(abs(t), end)
            bend = B0 + a * (
                B1 + a * (B2 + a * (B3 + a * (B4 + a * (B5 + a * (B6 + a * (B7 + a * B8))))))
            )
            total += max(t, none) + bend
        result[i] = total + constant
    return result
