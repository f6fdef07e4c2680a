"""Steps of particles: a turn, a straight and a turn, with noise on each.

Textbook twin: ``sample_motion_model_odometry`` of ``robot.localization.textbook``.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from robot.geometry import Array
from robot.localization.kernels.headings import heading_vector, wrapped
from robot.localization.kernels.noise import normal_rows

Parts = tuple[float, float, float, float]


@njit(cache=True, nogil=True, fastmath={"contract", "reassoc", "nsz"}, error_model="numpy")
def noisy_step(poses: Array, legs: Parts, deviations: Parts, key: int) -> Array:
    """Noise and motion in one; column by column, so that eight particles are moved at a time."""
    turn, ahead, aside, last = legs
    sd_turn, sd_ahead, sd_aside, sd_last = deviations
    noise = normal_rows(key, 4, len(poses))
    a, b, c, d = noise[0], noise[1], noise[2], noise[3]
    x, y, theta = poses[:, 0].copy(), poses[:, 1].copy(), poses[:, 2].copy()
    for i in range(len(poses)):
        toward = theta[i] + turn + sd_turn * a[i]
        go, shift = ahead + sd_ahead * b[i], aside + sd_aside * c[i]
        cosine, sine = heading_vector(toward)
        x[i] += cosine * go - sine * shift
        y[i] += sine * go + cosine * shift
        theta[i] = wrapped(toward + last + sd_last * d[i])
    return np.column_stack((x, y, theta))


@njit(cache=True, nogil=True)
def turn_go_turn(poses: Array, turn: Array, ahead: Array, aside: Array, last: Array) -> Array:
    """Poses (n, 3) after a step of each its own, given by its parts (n,)."""
    moved = np.empty((len(poses), 3))
    for i in range(len(poses)):
        toward = poses[i, 2] + turn[i]
        c, s = math.cos(toward), math.sin(toward)
        moved[i, 0] = poses[i, 0] + c * ahead[i] - s * aside[i]
        moved[i, 1] = poses[i, 1] + s * ahead[i] + c * aside[i]
        theta = toward + last[i]
        theta -= 2 * math.pi * math.floor((theta + math.pi) / (2 * math.pi))
        # By rounding it may come out as the full turn.
        moved[i, 2] = theta if theta < math.pi else -math.pi
    return moved
