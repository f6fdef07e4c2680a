"""Likelihood field: a scan fits a pose when its ends lie on edges of the map."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numba import float32, int32, njit, uint32
from numpy.polynomial import Chebyshev, Polynomial
from numpy.typing import NDArray

from robot.geometry import Array
from robot.localization.headings import heading_vector
from robot.localization.models.entry_field import DIRECTIONS, EntryField
from robot.localization.models.entry_planes import FARTHEST, STEEPEST, VALUE_SHIFT, X_SHIFT
from robot.scan import Scan

BATCH = 32
"""The compiler works on so many rays at a time; a scan is filled up with rays that say nothing."""

DEGREE = 8
FADED = 6.0
"""Where an edge makes a return likelier by no more than exp(-6), it is as good as none."""


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
        end, curve = self._curve
        # What the sum holds of the rays that it was filled up with, which are as far as can be.
        far = self._log_p(min(precision * field.max_distance**2, end))
        spare = (rays.shape[1] - used) * far
        return _sums(
            poses,
            rays,
            field.planes,
            field.origin,
            field.resolution,
            field.max_distance,
            precision * 2 / end,
            curve,
            -spare,
        )

    @cached_property
    def _curve(self) -> tuple[float, NDArray[np.float32]]:
        """Log p by x = d^2 / 2 sigma^2, as a polynomial of 2 x / end - 1; and that end.

        Past it log p is all but constant, up to it the polynomial is right to 1e-3.
        """
        end = max(self._log_p(0.0) - self._log_p(math.inf), 0.0) + FADED
        log_p = np.vectorize(self._log_p)
        fit = Chebyshev.interpolate(lambda t: log_p((t + 1) * end / 2), DEGREE)
        return end, fit.convert(kind=Polynomial).coef.astype(np.float32)

    def _log_p(self, x: float) -> float:
        """Of a ray that ends off an edge, by x = d^2 / 2 sigma^2."""
        false = max(self.z_rand / self.range_max, 1e-30)
        return math.log(self.z_hit * math.exp(-x) + false)


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


Curve = tuple[np.float32, ...]


@njit(cache=True, nogil=True, fastmath=True, error_model="numpy")
def _sums(
    poses: Array,
    rays: NDArray[np.float32],
    words: NDArray[np.int32],
    origin: tuple[float, float],
    resolution: float,
    max_distance: float,
    precision: float,
    curve: NDArray[np.float32],
    constant: float,
) -> Array:
    """A constant and the sum (n,) over rays of a curve of d^2 precision - 1, by poses (n, 3).

    Compiled such that sixteen rays are worked on together, 1 ns each: no branch and no call in the
    inner loop, one read of the table, and two poses side by side, as the one can go on while the
    other waits for memory.
    """
    _, height, width = words.shape
    table, shape = words.ravel(), (uint32(height - 1), uint32(width - 1))
    # Distances come in units of the word's value, squares of them in those of the curve.
    slope = float32(resolution / STEEPEST * FARTHEST / max_distance / 2 ** (32 - 2 * X_SHIFT - 9))
    unit = float32(precision * (max_distance / FARTHEST / 2**VALUE_SHIFT) ** 2)
    p = curve[0], curve[1], curve[2], curve[3], curve[4], curve[5], curve[6], curve[7], curve[8]
    places = _in_cells(poses, origin, 1.0 / resolution)
    turns = rays[2] * float32(DIRECTIONS / (2 * math.pi))
    result = np.empty(len(poses))
    for i in range(0, len(poses), 2):
        k = min(i + 1, len(poses) - 1)
        x0, y0, c0, s0, turn0 = places[i]
        x1, y1, c1, s1, turn1 = places[k]
        total0, total1 = float32(0.0), float32(0.0)
        for j in range(len(turns)):
            rx, ry, turn = rays[0, j], rays[1, j], turns[j]
            u0, v0 = x0 + c0 * rx - s0 * ry, y0 + s0 * rx + c0 * ry
            u1, v1 = x1 + c1 * rx - s1 * ry, y1 + s1 * rx + c1 * ry
            total0 += _log_p(u0, v0, turn0 + turn, table, shape, slope, unit, p)
            total1 += _log_p(u1, v1, turn1 + turn, table, shape, slope, unit, p)
        result[i] = total0 + constant
        result[k] = total1 + constant
    return result


@njit(cache=True, nogil=True, fastmath=True, error_model="numpy")
def _in_cells(poses: Array, origin: tuple[float, float], scale: float) -> NDArray[np.float32]:
    """x, y, cosine, sine in cells of the table, and the heading in its directions (n, 5)."""
    places = np.empty((len(poses), 5), dtype=np.float32)
    for i in range(len(poses)):
        cosine, sine = heading_vector(poses[i, 2])
        places[i, 0] = (poses[i, 0] - origin[0]) * scale
        places[i, 1] = (poses[i, 1] - origin[1]) * scale
        places[i, 2], places[i, 3] = cosine * scale, sine * scale
        # Rounded, and never below zero.
        places[i, 4] = poses[i, 2] * (DIRECTIONS / (2 * math.pi)) + 0.5 + 4 * DIRECTIONS
    return places


@njit(cache=True, nogil=True, fastmath=True, error_model="numpy", forceinline=True)
def _log_p(
    u: np.float32,
    v: np.float32,
    turn: np.float32,
    table: NDArray[np.int32],
    last: tuple[np.uint32, np.uint32],
    slope: np.float32,
    unit: np.float32,
    p: Curve,
) -> np.float32:
    """The curve's value for a ray that ends at column u and row v of the table.

    What is not on the table is cut to its last row or column, which is far from everything.
    """
    last_row, last_column = last
    # Below zero is far above it without a sign.
    column, row = min(np.uint32(np.int32(u)), last_column), min(np.uint32(np.int32(v)), last_row)
    facing = np.uint32(np.int32(turn)) & uint32(DIRECTIONS - 1)
    cell = uint32(facing * (last_row + uint32(1)) + row)
    cell = uint32(cell * (last_column + uint32(1)) + column)
    word = table[cell & uint32(0x7FFFFFFF)]
    along_x = float32(int32(word << int32(14))) * (u - float32(int32(column)))
    along_y = float32(int32(word << int32(23))) * (v - float32(int32(row)))
    d = float32(word) + (along_x + along_y) * slope
    t = min(d * d * unit - float32(1.0), float32(1.0))
    # Estrin's order of a polynomial: less waiting than Horner's.
    t2 = t * t
    t4 = t2 * t2
    low = (p[0] + p[1] * t) + t2 * (p[2] + p[3] * t)
    high = (p[4] + p[5] * t) + t2 * (p[6] + p[7] * t)
    value: np.float32 = float32(low + t4 * (high + t4 * p[8]))
    return value
