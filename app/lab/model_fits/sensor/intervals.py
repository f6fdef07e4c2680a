"""How sure the fitted values of the beam model are."""

from __future__ import annotations

import math
from dataclasses import astuple, dataclass, fields

import numpy as np
from numpy.typing import NDArray
from scipy.special import expit, logit

from app.lab.model_fits.sensor.climb import Climb, coordinates, values_at
from app.lab.model_fits.sensor.mixture import SHARES, FitRays, Limits, SensorValues, expect
from app.lab.model_fits.sensor.profiles import Profiles
from robot.geometry import Array

NAMES = tuple(one.name for one in fields(SensorValues))
NORMAL_95 = 1.959964
"""95 % of a normal distribution lie within so many standard deviations."""
NONE_SEEN = math.log(20)
"""A share at 0 may be so great that seeing none had a chance of 5 %: the rule of three."""
HARDLY_ANY = 0.5
"""With fewer rays of a kind, its share is at the border 0."""
FEW = 50
"""With fewer rays of a kind, its values have the intervals of the likelihood's profile."""
STEP = 1e-4
"""Of the differences that make second derivatives."""


@dataclass(frozen=True, slots=True)
class Intervals:
    """Standard errors, and the ends of 95 % intervals."""

    standard_errors: SensorValues
    low: SensorValues
    high: SensorValues
    at_border: tuple[str, ...]


def intervals(rays: FitRays, top: Climb, limits: Limits, worth: float) -> Intervals:
    """Intervals about the most likely values.

    From the observed information, the second derivatives of the exact log-likelihood by
    ``coordinates``: there it is the most symmetric. Where few rays tell of a value it is not, and
    the interval ends where the likelihood's profile has fallen by what is half of 1.96 squared. A
    share at the border 0 reaches to where it has fallen by ``NONE_SEEN``; its standard error is
    nan. A sigma_hit at its least is not greater than that, whatever it is.

    Args:
        rays: of the fit.
        top: where the likelihood is greatest.
        limits: of the fit.
        worth: how many independent rays one ray is worth.
    """
    border = _at_border(top, limits)
    spread = _spreads(rays, top.values, border) / math.sqrt(worth)
    middle = _unbounded(top.values)
    errors = spread * _slopes(top.values)
    errors[[NAMES.index(name) for name in border]] = np.nan
    ends = np.stack([_bounded(middle + side * NORMAL_95 * spread) for side in (-1, 1)])
    for name, (low, high) in _profiled(rays, top, limits, worth, border).items():
        ends[:, NAMES.index(name)] = low, high
        if name in border and name in SHARES:
            # What another share may be more than 0, z_hit may be less.
            ends[0, 0] *= 1 - high
    return Intervals(
        SensorValues(*errors.tolist()),
        SensorValues(*ends[0].tolist()),
        SensorValues(*ends[1].tolist()),
        border,
    )


def _at_border(top: Climb, limits: Limits) -> tuple[str, ...]:
    counts, rate = top.counts, top.values.lambda_short
    no_short = counts.returned_short < HARDLY_ANY
    conditions = {
        "z_short": no_short,
        "z_max": counts.missed == 0,
        "z_rand": counts.returned_rand < HARDLY_ANY,
        "sigma_hit": top.values.sigma_hit <= limits.sigma,
        "lambda_short": no_short or not limits.rate[0] < rate < limits.rate[1],
    }
    return tuple(name for name, met in conditions.items() if met)


def _profiled(
    rays: FitRays, top: Climb, limits: Limits, worth: float, border: tuple[str, ...]
) -> dict[str, tuple[float, float]]:
    """Intervals of the values that few rays tell of."""
    profiles, counts = Profiles(rays, top, limits), top.counts
    drops = {name: NONE_SEEN if name in border else NORMAL_95**2 / 2 for name in NAMES}
    found = {}
    if "sigma_hit" in border:
        found["sigma_hit"] = 0.0, limits.sigma
    if "z_max" in border:
        # The likelihood is z_hit / (z_hit + z_max) to the power of the hits.
        on = top.values.z_hit + top.values.z_max
        found["z_max"] = 0.0, on * -math.expm1(-NONE_SEEN / worth / counts.hit)
    for name, told in (("z_short", counts.returned_short), ("z_rand", counts.returned_rand)):
        if told * worth < FEW:
            found[name] = profiles.share(name, drops[name] / worth)
    if "z_short" in border:
        found["lambda_short"] = 0.0, math.inf
    elif "lambda_short" in border or counts.returned_short * worth < FEW:
        found["lambda_short"] = profiles.rate(drops["lambda_short"] / worth)
    return found


def _spreads(rays: FitRays, values: SensorValues, border: tuple[str, ...]) -> Array:
    """Standard errors (6,) of the log-odds and logarithms of the values."""
    # In the order of coordinates.
    names = ("z_short", "z_rand", "z_max", "sigma_hit", "lambda_short")
    free = np.array([name not in border for name in names])
    if not free.any():
        return np.zeros(len(NAMES))
    information, slopes = _information(rays, values, free)
    if np.linalg.eigvalsh(information)[0] <= 0:
        # Flat, as short and even ranges cannot be told apart: those have profiles.
        free[-1] = False
        information, slopes = _information(rays, values, free)
    covariance = slopes @ np.linalg.pinv(information, hermitian=True) @ slopes.T
    spreads: Array = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    return spreads


def _information(
    rays: FitRays, values: SensorValues, free: NDArray[np.bool_]
) -> tuple[Array, Array]:
    """Observed information (k, k) by the free coordinates, and slopes (6, k) of the values."""
    place = coordinates(values)
    curves, slopes = [], []
    for step in STEP * np.eye(len(place))[free]:
        ahead, behind = values_at(place + step), values_at(place - step)
        curves.append((_gradient(rays, behind) - _gradient(rays, ahead))[free])
        with np.errstate(invalid="ignore"):
            slopes.append(np.nan_to_num(_unbounded(ahead) - _unbounded(behind)))
    information = np.array(curves) / (2 * STEP)
    return (information + information.T) / 2, np.array(slopes).T / (2 * STEP)


def _gradient(rays: FitRays, values: SensorValues) -> Array:
    """Slope (5,) of the log-likelihood by ``coordinates`` (Fisher's identity)."""
    counts, count = expect(rays, values), len(rays.begin)
    straight = values.z_hit / (values.z_hit + values.z_max)
    return np.array(
        [
            counts.short - count * values.z_short,
            counts.rand - count * values.z_rand,
            counts.hit - (counts.hit + counts.missed) * straight,
            counts.square / values.sigma_hit**2 - counts.hit,
            counts.short - values.lambda_short * counts.way,
        ]
    )


def _unbounded(values: SensorValues) -> Array:
    """Log-odds of the shares, logarithms of the others (6,)."""
    numbers = np.array(astuple(values))
    with np.errstate(divide="ignore"):
        return np.concatenate([logit(numbers[:4]), np.log(numbers[4:])])


def _bounded(numbers: Array) -> Array:
    """Shares and others (6,) of which these are the log-odds and logarithms."""
    with np.errstate(over="ignore"):
        return np.concatenate([expit(numbers[:4]), np.exp(numbers[4:])])


def _slopes(values: SensorValues) -> Array:
    """Of the values (6,) by their log-odds or logarithms."""
    numbers = np.array(astuple(values))
    return np.concatenate([numbers[:4] * (1 - numbers[:4]), numbers[4:]])
