"""A step as turn, go, turn: what any planar motion can be cut into, and how its errors spread."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from robot.geometry import Array
from robot.localization.kernels.headings import heading_vector, wrapped
from robot.localization.kernels.noise import noise_key, normal_rows


class Legs(NamedTuple):
    """A step seen from its start, or the standard deviations of its parts."""

    turn: float
    """First, toward where it goes [rad]."""
    ahead: float
    """Then so far [m]."""
    aside: float
    """And so far to the left [m]."""
    last: float
    """Then once more [rad]."""


def sample_legs(poses: Array, legs: Legs, deviations: Legs, rng: np.random.Generator) -> Array:
    """Where poses (n, 3) get to when each part errs by itself, by a normal distribution."""
    return _step(poses, (*legs,), (*deviations,), noise_key(rng))


Parts = tuple[float, float, float, float]


@njit(cache=True, nogil=True, fastmath={"contract", "reassoc", "nsz"}, error_model="numpy")
def _step(poses: Array, legs: Parts, deviations: Parts, key: int) -> Array:
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


def spread_of(legs: Legs, covariance: Array) -> Array:
    """Covariance (3, 3) [m, m, rad] of a step's end, seen from its start, for small errors.

    J C J^T, with the covariance C (4, 4) of the parts and J what the end moves by with each.
    """
    c, s = math.cos(legs.turn), math.sin(legs.turn)
    x, y = c * legs.ahead - s * legs.aside, s * legs.ahead + c * legs.aside
    J = np.array([[-y, c, -s, 0.0], [x, s, c, 0.0], [1.0, 0.0, 0.0, 1.0]])
    end: Array = J @ covariance @ J.T
    return end


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
