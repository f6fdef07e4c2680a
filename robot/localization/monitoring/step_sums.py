"""Compiled sums over steps, to find the steady errors by which odometry and poses differ."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from robot.compiling import compiled
from robot.covariance import inverse, outer
from robot.geometry import Array
from robot.localization.monitoring.steady_errors import MEMORY
from robot.localization.scan_matching import TAIL

RECENT = 3.0
"""Steps older than this hardly count for the unexplained rest [s]."""
CORRELATION = 5.0
"""This many steps at the same speed are worth one, because slip lasts for about a second. Half:
false alarms in 0.9 % of pictures instead of none; twice: nothing changes beyond chance (``python -m
benchmarks.constants --few``)."""
TELLING, CHANGE_V, CHANGE_OMEGA = 2.0, 0.05, 0.4
"""A step over which the speed changes by more than CHANGE [m/s, rad/s] is worth TELLING steps: slip
is the same before and after it, and lateness shows."""
MOST = 100.0
"""Largest square that a step counts for, in its spreads."""
SMALL = 1e-4
"""Step of derivatives by differences [m, rad, s]."""


class StepSums(NamedTuple):
    """Sums over steps; older steps count less."""

    prior: Array
    """(7, 7) information on the errors before any step."""
    prior_pull: Array
    """(7,) that information times the errors before any step."""
    information: Array
    """(3, 7, 7) information on the errors by the steps ahead, aside and in heading, if these have
    their usual spreads."""
    pull: Array
    """(3, 7) information times errors."""
    left: Array
    """(3,) unexplained rest of the last seconds' steps [m, m, rad], as far as poses were known."""
    evidence: Array
    """(3,) how many such steps there were; one counts as far as its poses were known."""
    squares: Array
    """(3,) squares of that rest without its mean, in its spreads."""
    counts: Array
    """(2,): number of steps, and of the last seconds' steps."""


@compiled()
def add_step(
    sums: StepSums,
    values: Array,
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
    """Add a step to the sums, and update the estimate of the errors.

    Args:
        sums: sums over the steps before; they are updated.
        values: the errors (7,) as estimated before.
        moved: the step (3,) by odometry.
        went: the step (3,) by the filter's poses.
        first: v and omega at the step's start [m/s, rad/s].
        last: v and omega at the step's end [m/s, rad/s].
        covariance_before: (3, 3) of the pose at the step's start, along the robot's axes.
        covariance_after: (3, 3) of the pose at the step's end, along the robot's axes.
        elapsed: time since the last step [s].
        duration: duration of this step [s].
        settled: whether the place has been followed for long enough.

    Returns:
        Values (7,), covariance (7, 7), and the unexplained rest of steps (3,), in spreads.
    """
    offset = _compose(_inverse(moved), went)
    offset[2] = (offset[2] + math.pi) % (2 * math.pi) - math.pi
    way = abs(moved[0]) + 0.06 * abs(moved[2])
    spread = np.array([0.0003 + 0.012 * way, 0.0002 + 0.003 * way, 0.001 + 0.18 * way])
    variance = spread**2 + np.diag(covariance_before) + np.diag(covariance_after)
    columns = step_columns(
        moved, np.array([first[0], 0.0, first[1]]), np.array([last[0], 0.0, last[1]])
    )
    # Steps overlap, so each counts as a share. But only few of them contain a change of speed.
    share = elapsed / max(duration, 1e-3)
    keep, recent = math.exp(-elapsed / MEMORY), math.exp(-elapsed / RECENT)
    left = offset - columns @ values
    sums.counts[1] = recent * sums.counts[1] + share
    # Where the pose was hardly known, and is found, a step is long without any slip.
    tells = share * spread**2 / variance
    sums.left[:] = recent * sums.left + tells * left
    sums.evidence[:] = recent * sums.evidence + tells
    # A steady difference is no slip, even if it is not learnt yet.
    unsteady = (left - sums.left / (sums.evidence + 1)) ** 2 / variance
    if not settled:
        unsteady[:2] = np.minimum(unsteady[:2], 1.0)
    weights = share / (variance * (1 + unsteady / TAIL))
    if not settled:  # a given place is corrected at first, which is no lateness
        weights[:2] = 0.0
    sums.information[:] *= keep
    sums.pull[:] *= keep
    changes = abs(last[0] - first[0]) > CHANGE_V or abs(last[1] - first[1]) > CHANGE_OMEGA
    if not changes:
        # The noise of a steady speed would seem to tell that pictures are in time.
        columns[:, 0] = 0.0
    _add(sums, columns, offset, weights / CORRELATION)
    if changes:
        # The second in which the speed changes shall say nothing about the wheels' errors.
        by_wheels = np.zeros(7)
        by_wheels[1:4] = values[1:4]
        beside_wheels = offset - columns @ by_wheels
        columns[:, 1:4] = 0.0
        _add(sums, columns, beside_wheels, min(TELLING, 1 / share) * weights)
    sums.squares[:] = recent * sums.squares + share * np.minimum(unsteady, MOST)
    sums.counts[0] = keep * sums.counts[0] + share
    return estimate_errors(sums)


@compiled()
def forget_lateness(sums: StepSums, value: float, sd: float) -> None:
    """Take lateness as known to a standard deviation only, whatever steps told [s]."""
    for axis in range(3):
        known = sums.information[axis, 0].copy()
        if known[0] > 0:
            sums.pull[axis] -= known * (sums.pull[axis, 0] / known[0])
            sums.information[axis] -= outer(known, known) / known[0]
    sums.prior[0, 0], sums.prior_pull[0] = 1 / sd**2, value / sd**2


@compiled()
def _add(sums: StepSums, columns: Array, offset: Array, weights: Array) -> None:
    """Add the information of a step (3,) on the errors, by its columns (3, 7)."""
    for axis in range(3):
        sums.information[axis] += outer(weights[axis] * columns[axis], columns[axis])
        sums.pull[axis] += weights[axis] * offset[axis] * columns[axis]


@compiled()
def estimate_errors(sums: StepSums) -> tuple[Array, Array, Array]:
    """Return the errors (7,), their covariance (7, 7), and the unexplained rest of steps (3,)."""
    # The sums begin as if one usual step came before all others.
    rest = np.sqrt((sums.squares + 1) / (sums.counts[1] + 1))
    # While wheels slip, steps say less about the steady errors, also those before that shows.
    worth = 1 / np.maximum(rest**2, 1.0)
    covariance = inverse(sums.prior + (worth.reshape(3, 1, 1) * sums.information).sum(axis=0))
    return covariance @ (sums.prior_pull + worth @ sums.pull), covariance, rest


@compiled()
def step_columns(moved: Array, first: Array, last: Array) -> Array:
    """Return how a step changes by a unit of each of ``ERRORS`` (3, 7), seen from its end.

    Args:
        moved: the step (3,) by odometry.
        first: velocity (3,) at its start.
        last: velocity (3,) at its end.
    """
    columns = np.zeros((3, 7))
    inverse = _inverse(moved)
    # The step between the robot's poses tau earlier, at both ends.
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


@compiled(inline="always")
def _compose(a: Array, b: Array) -> Array:
    c, s = math.cos(a[2]), math.sin(a[2])
    return np.array([a[0] + c * b[0] - s * b[1], a[1] + s * b[0] + c * b[1], a[2] + b[2]])


@compiled(inline="always")
def _inverse(a: Array) -> Array:
    c, s = math.cos(a[2]), math.sin(a[2])
    return np.array([-c * a[0] - s * a[1], s * a[0] - c * a[1], -a[2]])
