"""Ranges drawn from the beam model with known values."""

from __future__ import annotations

import numpy as np

from app.features.lab.model_fits.beam_fit import SensorValues
from app.features.lab.model_fits.range_pairs import RangePairs
from robot.localization.models.beam import MISSED_AT_END, MISSED_AT_START

HIT, SHORT, _, RAND = range(4)
NO_EDGE = 0.15
"""Share of the rays that have no edge in sight."""


def draw_ranges(
    values: SensorValues,
    count: int,
    rng: np.random.Generator,
    sight: tuple[float, float] = (0.0, 1.0),
) -> RangePairs:
    """First what becomes of each ray, then its range, of 1 m at most.

    What would be short or false where the ray does not see, or short behind the edge, does not
    touch it: it goes on, and hits the edge or misses it.
    """
    near, far = sight
    expected = rng.uniform(near + MISSED_AT_START, far - MISSED_AT_END, count)
    expected[rng.random(count) < NO_EDGE] = np.inf
    shares = [values.z_hit, values.z_short, values.z_max, values.z_rand]
    kind = rng.choice(4, count, p=shares)
    short = rng.exponential(1 / values.lambda_short, count)
    false = rng.uniform(0.0, 1.0, count)
    is_short = (kind == SHORT) & (near <= short) & (short <= np.minimum(expected, far))
    is_false = (kind == RAND) & (near <= false) & (false <= far)
    again = rng.random(count) < values.z_hit / (values.z_hit + values.z_max)
    hits = np.where((kind == SHORT) | (kind == RAND), again, kind == HIT)
    edge = np.where(hits, expected + rng.normal(0, values.sigma_hit, count), np.inf)
    measured = np.where(is_short, short, np.where(is_false, false, edge))
    return RangePairs(
        measured,
        expected,
        np.zeros(count),
        np.zeros(count, dtype=int),
        np.arange(count),
        np.isfinite(expected),
        np.tile([near, far], (count, 1)),
    )
