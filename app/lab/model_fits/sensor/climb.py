"""Expectation maximization until the likelihood of the beam model no longer rises."""

from __future__ import annotations

import math
from dataclasses import astuple, dataclass

import numpy as np
from scipy.special import expit, logit

from app.lab.model_fits.sensor.mixture import (
    Counts,
    FitRays,
    Limits,
    SensorValues,
    expect,
    maximize,
)
from robot.geometry import Array

MOST_ITERATIONS = 1000
ENOUGH = 1e-6
"""A rise of the log-likelihood by less is none."""
LEAST_PART = 0.01


@dataclass(frozen=True, slots=True)
class Climb:
    """Where it ended, and how it got there."""

    values: SensorValues
    counts: Counts
    log_likelihoods: tuple[float, ...]
    """At the start and after each iteration."""
    converged: bool


def climb(rays: FitRays, start: SensorValues, limits: Limits, enough: float = ENOUGH) -> Climb:
    """Iterate from start values until the log-likelihood rises by less than ``enough``.

    Each iteration is two steps of expectation maximization and, if that is no worse, a leap along
    their direction (SQUAREM, Varadhan and Roland 2008, scheme S3): the steps alone get short where
    even and exponential false returns are hard to tell apart.
    """
    values, counts = start, expect(rays, start)
    rises = [counts.log_likelihood]
    for _ in range(MOST_ITERATIONS):
        once = maximize(counts, limits, values.lambda_short)
        twice = maximize(expect(rays, once), limits, once.lambda_short)
        after = expect(rays, twice)
        leapt = _leap(values, once, twice, limits)
        if leapt is not None:
            there = expect(rays, leapt)
            if there.log_likelihood >= after.log_likelihood:
                twice, after = leapt, there
        values, counts = twice, after
        rises.append(counts.log_likelihood)
        if rises[-1] - rises[-2] < enough:
            return Climb(values, counts, tuple(rises), converged=True)
    return Climb(values, counts, tuple(rises), converged=False)


def _leap(
    start: SensorValues, once: SensorValues, twice: SensorValues, limits: Limits
) -> SensorValues | None:
    """Beyond two steps, by how much the second was shorter; None if there is no telling.

    Values stay above 0: they fall to a small part of what they are at most.
    """
    begin, middle, end = (np.array(astuple(values)) for values in (start, once, twice))
    # Metres and rates by how much they change, as shares are.
    size = np.array([1.0, 1.0, 1.0, 1.0, end[4], end[5]])
    step, bend = middle - begin, end - 2 * middle + begin
    length = float(np.linalg.norm(bend / size))
    stride = float(np.linalg.norm(step / size)) / length if length > 0 else 0.0
    if stride <= 1.0:
        return None
    leapt = np.maximum(begin + 2 * stride * step + stride**2 * bend, LEAST_PART * end)
    return limits.within(SensorValues(*leapt.tolist()))


def coordinates(values: SensorValues) -> Array:
    """Values as any five numbers.

    Logarithms of z_short and z_rand over z_hit + z_max, log-odds of z_hit against z_max, and
    logarithms of sigma_hit and lambda_short; infinite where a share is 0.
    """
    on = values.z_hit + values.z_max
    with np.errstate(divide="ignore"):
        shares = np.log(np.array([values.z_short, values.z_rand]) / on)
        straight = logit(values.z_hit / on)
    return np.array([*shares, straight, math.log(values.sigma_hit), math.log(values.lambda_short)])


def values_at(place: Array) -> SensorValues:
    """The values at coordinates (5,)."""
    short, rand = np.exp(place[:2]).tolist()
    on, straight = 1 / (1 + short + rand), float(expit(place[2]))
    return SensorValues(
        on * straight,
        on * short,
        on * (1 - straight),
        on * rand,
        math.exp(place[3]),
        math.exp(place[4]),
    )
