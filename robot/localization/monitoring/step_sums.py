"""Compiled sums over steps: which steady errors explain that odometry and poses differ?"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from robot.geometry import Array
from robot.localization.kernels.matrices import inverse

MEMORY = 20.0
"""Steps older than this hardly count for errors that stay [s]."""
RECENT = 3.0
"""The same for what is left unexplained [s]."""
CORRELATION = 5.0
"""Slip lasts for about a second: so many steps at the same speed are worth one."""
PRIOR_SD = np.array([0.015, 0.03, 0.5, 0.04, 0.002, 0.002, 0.008])
"""How far robots are off that nobody has calibrated [s, -, rad/m, -, m, m, rad]."""
PRIOR = np.diag(PRIOR_SD**-2)
TELLING, CHANGE_V, CHANGE_OMEGA = 2.0, 0.05, 0.4
"""A step over which the speed changes by more than this [m/s, rad/s] is worth so many: there slip
is the same before and after, and what is late shows."""
MOST = 100.0
"""Squares of its spread that a step counts for, at most."""
MOST_WIGGLE = np.square([0.05, 0.05, 0.2])
SMALL = 1e-4
TAIL = 9.0


class StepSums(NamedTuple):
    """What is added up over steps; a step counts the less the longer ago it was."""

    information: Array
    """(7, 7) on the errors."""
    pull: Array
    """(7,)"""
    left: Array
    """(3,) of what is left unexplained of the last seconds' steps."""
    squares: Array
    """(3,) of the same, by its spread."""
    wiggle: Array
    """(3,) of the same [m², m², rad²]."""
    counts: Array
    """(2,): steps, and steps of the last seconds."""


@njit(cache=True, nogil=True)
def learned(
    sums: StepSums,
    values: Array,
    rest: Array,
    moved: Array,
    went: Array,
    first: tuple[float, float],
    last: tuple[float, float],
    covariance_before: Array,
    covariance_after: Array,
    elapsed: float,
    duration: float,
    settled: bool,
) -> tuple[Array, Array, Array]:
    """Add a step to the sums, and estimate the errors anew.

    Args:
        sums: of the steps before.
        values: of the errors (7,), as they were estimated.
        rest: what was left of steps (3,).
        moved: the step (3,) by odometry.
        went: the same by the filter's poses.
        first: v and omega at its start [m/s, rad/s].
        last: the same at its end.
        covariance_before: of the pose at its start (3, 3), along the robot's axes.
        covariance_after: the same at its end.
        elapsed: since the last step [s].
        duration: of this one [s].
        settled: whether the place has been followed for long enough.

    Returns:
        Values (7,), covariance (7, 7), and what is left of steps (3,).
    """
    offset = _compose(_inverse(moved), went)
    offset[2] = (offset[2] + math.pi) % (2 * math.pi) - math.pi
    way = abs(moved[0]) + 0.06 * abs(moved[2])
    spread = np.array([0.0003 + 0.012 * way, 0.0002 + 0.003 * way, 0.001 + 0.18 * way])
    variance = spread**2 + np.diag(covariance_before) + np.diag(covariance_after)
    columns = step_columns(
        moved, np.array([first[0], 0.0, first[1]]), np.array([last[0], 0.0, last[1]])
    )
    # Steps overlap; but what a change of speed tells, few of them tell.
    share = elapsed / max(duration, 1e-3)
    keep, recent = math.exp(-elapsed / MEMORY), math.exp(-elapsed / RECENT)
    left = offset - columns @ values
    sums.counts[1] = recent * sums.counts[1] + share
    sums.left[:] = recent * sums.left + share * left
    # What stays off is no slip, though it may not be learnt yet.
    unsteady = (left - sums.left / (sums.counts[1] + 1)) ** 2 / variance
    if not settled:
        unsteady[:2] = np.minimum(unsteady[:2], 1.0)
    # What slips now says less of what stays.
    wide = variance * np.maximum(rest**2, 1.0)
    weights = share / (wide * (1 + unsteady / TAIL))
    sums.information[:] *= keep
    sums.pull[:] *= keep
    _add(sums, columns, offset, weights / CORRELATION)
    if abs(last[0] - first[0]) > CHANGE_V or abs(last[1] - first[1]) > CHANGE_OMEGA:
        # What its wheels are off by is not told by the one second in which it changes.
        by_wheels = np.zeros(7)
        by_wheels[1:4] = values[1:4]
        beside_wheels = offset - columns @ by_wheels
        columns[:, 1:4] = 0.0
        _add(sums, columns, beside_wheels, min(TELLING, 1 / share) * weights)
    sums.squares[:] = recent * sums.squares + share * np.minimum(unsteady, MOST)
    sums.wiggle[:] = recent * sums.wiggle + share * np.minimum(left**2, MOST_WIGGLE)
    sums.counts[0] = keep * sums.counts[0] + share
    return likeliest(sums)


@njit(cache=True, nogil=True)
def _add(sums: StepSums, columns: Array, offset: Array, weights: Array) -> None:
    """Add what a step (3,) tells of the errors, by its columns (3, 7)."""
    weighed = np.ascontiguousarray(columns.T * weights)
    sums.information[:] += weighed @ columns
    sums.pull[:] += weighed @ offset


@njit(cache=True, nogil=True)
def likeliest(sums: StepSums) -> tuple[Array, Array, Array]:
    """Values (7,) of the errors, their covariance (7, 7), and what is left of steps (3,)."""
    covariance = inverse(sums.information + PRIOR)
    # As if a step before any had been as usual.
    rest = np.sqrt((sums.squares + 1) / (sums.counts[1] + 1))
    return covariance @ sums.pull, covariance, rest


@njit(cache=True, nogil=True)
def step_columns(moved: Array, first: Array, last: Array) -> Array:
    """How a step (3, 7) changes by a unit of each of ``ERRORS``, seen from its end.

    Args:
        moved: the step (3,) by odometry.
        first: velocity (3,) at its start.
        last: velocity (3,) at its end.
    """
    columns = np.zeros((3, 7))
    inverse = _inverse(moved)
    # Where it was tau earlier, at both ends.
    late = _compose(_compose(SMALL * first, moved), -SMALL * last)
    columns[:, 0] = _compose(inverse, late) / SMALL
    c, s = math.cos(moved[2]), math.sin(moved[2])
    columns[0, 1], columns[1, 1] = c * moved[0] + s * moved[1], c * moved[1] - s * moved[0]
    columns[1, 2], columns[2, 2] = 0.5 * moved[0] * moved[0], moved[0]
    columns[1, 3], columns[2, 3] = 0.5 * moved[0] * moved[2], moved[2]
    for axis in range(3):
        offset = np.zeros(3)
        offset[axis] = SMALL
        beside = _compose(_compose(_inverse(offset), moved), offset)
        columns[:, 4 + axis] = _compose(inverse, beside) / SMALL
    return columns


@njit(cache=True, nogil=True, inline="always")
def _compose(a: Array, b: Array) -> Array:
    c, s = math.cos(a[2]), math.sin(a[2])
    return np.array([a[0] + c * b[0] - s * b[1], a[1] + s * b[0] + c * b[1], a[2] + b[2]])


@njit(cache=True, nogil=True, inline="always")
def _inverse(a: Array) -> Array:
    c, s = math.cos(a[2]), math.sin(a[2])
    return np.array([-c * a[0] - s * a[1], s * a[0] - c * a[1], -a[2]])
