"""A step as turn, go, turn: what any planar motion can be cut into, and how its errors spread."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from robot.geometry import Array
from robot.localization.kernels.noise import noise_key
from robot.localization.kernels.steps import noisy_step


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
    return noisy_step(poses, (*legs,), (*deviations,), noise_key(rng))


def spread_of(legs: Legs, covariance: Array) -> Array:
    """Covariance (3, 3) [m, m, rad] of a step's end, seen from its start, for small errors.

    J C J^T, with the covariance C (4, 4) of the parts and J what the end moves by with each.
    """
    c, s = math.cos(legs.turn), math.sin(legs.turn)
    x, y = c * legs.ahead - s * legs.aside, s * legs.ahead + c * legs.aside
    J = np.array([[-y, c, -s, 0.0], [x, s, c, 0.0], [1.0, 0.0, 0.0, 1.0]])
    end: Array = J @ covariance @ J.T
    return end
