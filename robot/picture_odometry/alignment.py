"""How two patches of the floor lie to each other: sums of least squares over their pixels.

The patch is moved until both agree: Gauss and Newton's steps on the difference of brightness, with
the mean gradient of both (Malis 2004, ESM). Three things keep it honest. Pixels are weighed by
their noise and by their gradient, so that the steep edge of a tape counts as little more than a
grain of wood. The information is the product of the gradients of the *two* pictures, in which the
noise of one and of the other cancel on average: on a bare floor it is zero, while squared gradients
of noise look like a floor. And the covariance is that of the sums themselves (the sandwich).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from robot.compiling import compiled
from robot.geometry import Array

Patch = NDArray[np.float32]
"""(h, w, 3) brightness without its large areas, and its slopes forward and left [grey levels a
pixel]."""

POSITION_SD = 0.25
"""How far an edge may seem to be from where it is [px], by what lens, projection and interpolation
do: the steep edge of a tape counts no more than this allows."""

MARGIN = 8
"""So many pixels at a patch's border are not used: large areas are not known there [px]."""

AB, AA, BB, WEIGHT, RESIDUAL, COUNT, SQUARES = range(7)
"""Places in ``totals``."""


@compiled(inline="always", fastmath=True)
def _between(patch: Patch, v: float, u: float) -> tuple[float, float, float]:
    """Return brightness and slopes between the pixels of a patch, at row v and column u."""
    i, j = int(v), int(u)
    fv, fu = v - i, u - j
    w00, w01, w10, w11 = (1 - fv) * (1 - fu), (1 - fv) * fu, fv * (1 - fu), fv * fu
    first, second, third, last = patch[i, j], patch[i, j + 1], patch[i + 1, j], patch[i + 1, j + 1]
    return (
        w00 * first[0] + w01 * second[0] + w10 * third[0] + w11 * last[0],
        w00 * first[1] + w01 * second[1] + w10 * third[1] + w11 * last[1],
        w00 * first[2] + w01 * second[2] + w10 * third[2] + w11 * last[2],
    )


@compiled(fastmath=True)
def slopes(fine: NDArray[np.float32], coarse: NDArray[np.float32], patch: Patch) -> None:
    """Fill a patch from a smoothed picture of the floor (h, w), and one of its large areas."""
    height, width = fine.shape
    for row in range(height):
        above, below = max(row - 1, 0), min(row + 1, height - 1)
        for column in range(width):
            left, right = max(column - 1, 0), min(column + 1, width - 1)
            patch[row, column, 0] = fine[row, column] - coarse[row, column]
            patch[row, column, 1] = (fine[above, column] - fine[below, column]) * 0.5
            patch[row, column, 2] = (fine[row, left] - fine[row, right]) * 0.5


@compiled(fastmath=True)
def similarity(
    before: Patch, after: Patch, motion: Array, skew: Array, variance: float, stride: int
) -> float:
    """Return the weighed correlation of two patches at a motion, -1 to 1.

    Args as in ``accumulate``.
    """
    height, width, _ = before.shape
    c, s = math.cos(motion[2]), math.sin(motion[2])
    ab = aa = bb = 1e-9
    for row in range(MARGIN, height - MARGIN, stride):
        px = (height - 1) * 0.5 - row
        for column in range(MARGIN, width - MARGIN, stride):
            py = (width - 1) * 0.5 - column
            ex = (c * px + s * py) * (1 + motion[3]) - motion[0] - px
            ey = (c * py - s * px) * (1 + motion[3]) - motion[1] - py
            longer = 1 + skew[row] * ex
            v, u = row - longer * ex, column - longer * ey
            if not (MARGIN <= v < height - MARGIN and MARGIN <= u < width - MARGIN):
                continue
            b, _, _ = _between(after, v, u)
            a = before[row, column, 0]
            gx, gy = before[row, column, 1], before[row, column, 2]
            weight = 1 / (variance + POSITION_SD**2 * (gx * gx + gy * gy))
            ab += weight * a * b
            aa += weight * a * a
            bb += weight * b * b
    return ab / math.sqrt(aa * bb)


@compiled(fastmath=True)
def step_sums(
    before: Patch,
    after: Patch,
    motion: Array,
    skew: Array,
    variance: float,
    stride: int,
    sums: Array,
) -> None:
    """Sum what a step needs (9,): the right side, and the information's lower triangle by rows.

    Args as in ``accumulate``, of which it is the part without the floor's growth and without what
    is only told in the end: it takes a fifth of the time.
    """
    height, width, _ = before.shape
    c, s = math.cos(motion[2]), math.sin(motion[2])
    b0 = b1 = b2 = h00 = h10 = h11 = h20 = h21 = h22 = 0.0
    for row in range(MARGIN, height - MARGIN, stride):
        px = (height - 1) * 0.5 - row
        for column in range(MARGIN, width - MARGIN, stride):
            py = (width - 1) * 0.5 - column
            rx, ry = c * px + s * py, c * py - s * px
            ex, ey = rx - motion[0] - px, ry - motion[1] - py
            longer = 1 + skew[row] * ex
            v, u = row - longer * ex, column - longer * ey
            if not (MARGIN <= v < height - MARGIN and MARGIN <= u < width - MARGIN):
                continue
            b, b_ahead, b_left = _between(after, v, u)
            ax, ay = before[row, column, 1], before[row, column, 2]
            residual = b - before[row, column, 0]
            weight = 1 / (variance + POSITION_SD**2 * (ax * ax + ay * ay))
            weight /= 1 + residual * residual * weight / 9
            j0, j1 = -0.5 * (ax + b_ahead), -0.5 * (ay + b_left)
            j2 = j1 * rx - j0 * ry
            weighed = weight * residual
            b0 -= weighed * j0
            b1 -= weighed * j1
            b2 -= weighed * j2
            h00 += weight * j0 * j0
            h10 += weight * j1 * j0
            h11 += weight * j1 * j1
            h20 += weight * j2 * j0
            h21 += weight * j2 * j1
            h22 += weight * j2 * j2
    sums[0], sums[1], sums[2], sums[3], sums[4] = b0, b1, b2, h00, h10
    sums[5], sums[6], sums[7], sums[8] = h11, h20, h21, h22


@compiled(fastmath=True)
def accumulate(
    before: Patch,
    after: Patch,
    motion: Array,
    skew: Array,
    variance: float,
    stride: int,
    right: Array,
    squared: Array,
    crossed: Array,
    spread: Array,
    totals: Array,
) -> None:
    """Sum the normal equations of a step; all sums are set, not added to.

    Args:
        before: the first patch.
        after: the second one.
        motion: (4,) of the robot at the patch's middle: forward and left [px], turn [rad]; and by
            which share the floor looks larger.
        skew: (h,) how much longer each pixel of forward displacement took to read out, as a share.
        variance: of the difference of brightness [grey levels^2].
        stride: every how many pixels are used, in each direction.
        right: gets the right side (4,).
        squared: gets the information by mean gradients (4, 4).
        crossed: gets the information by the product of both gradients (4, 4).
        spread: gets the covariance of the right side, if pixels were independent (4, 4).
        totals: gets sums (7,) for the correlation, weights, squared residuals, pixels, and of the
            squares of what each pixel tells of a shift.
    """
    height, width, _ = before.shape
    c, s = math.cos(motion[2]), math.sin(motion[2])
    larger = 1 + motion[3]
    right[:], squared[:], crossed[:], spread[:], totals[:] = 0.0, 0.0, 0.0, 0.0, 0.0
    ja, jb, jm = np.empty(4), np.empty(4), np.empty(4)
    for row in range(MARGIN, height - MARGIN, stride):
        px = (height - 1) * 0.5 - row
        for column in range(MARGIN, width - MARGIN, stride):
            py = (width - 1) * 0.5 - column
            rx, ry = (c * px + s * py) * larger, (c * py - s * px) * larger
            ex, ey = rx - motion[0] - px, ry - motion[1] - py
            longer = 1 + skew[row] * ex
            v, u = row - longer * ex, column - longer * ey
            if not (MARGIN <= v < height - MARGIN and MARGIN <= u < width - MARGIN):
                continue
            b, b_ahead, b_left = _between(after, v, u)
            a, ax, ay = before[row, column, 0], before[row, column, 1], before[row, column, 2]
            residual = b - a
            # An outlier, as what moved on the floor, counts as one of three deviations.
            weight = 1 / (variance + POSITION_SD**2 * (ax * ax + ay * ay))
            weight /= 1 + residual * residual * weight / 9
            ja[0], ja[1], ja[2], ja[3] = -ax, -ay, ax * ry - ay * rx, ax * rx + ay * ry
            jb[0], jb[1], jb[2], jb[3] = (
                -b_ahead,
                -b_left,
                b_ahead * ry - b_left * rx,
                b_ahead * rx + b_left * ry,
            )
            for k in range(4):
                jm[k] = 0.5 * (ja[k] + jb[k])
            weighed = weight * residual
            for k in range(4):
                right[k] -= weighed * jm[k]
                for m in range(k + 1):
                    squared[k, m] += weight * jm[k] * jm[m]
                    crossed[k, m] += weight * 0.5 * (ja[k] * jb[m] + ja[m] * jb[k])
                    spread[k, m] += weighed * weighed * jm[k] * jm[m]
            totals[0] += weight * a * b
            totals[1] += weight * a * a
            totals[2] += weight * b * b
            totals[3] += weight
            totals[4] += weighed * residual
            totals[5] += 1
            tells = weight * (jm[0] * jm[0] + jm[1] * jm[1])
            totals[6] += tells * tells
    for k in range(4):
        for m in range(k):
            squared[m, k] = squared[k, m]
            crossed[m, k] = crossed[k, m]
            spread[m, k] = spread[k, m]
