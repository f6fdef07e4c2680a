"""The fit of the beam model finds the values that ranges were drawn with, and how sure it is."""

from __future__ import annotations

import math
from dataclasses import asdict, astuple, fields, replace
from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.special import logit
from sensor_draws import draw_ranges

from app.features.lab.model_fits.beam_fit import (
    SensorFit,
    SensorValues,
    beam_loss,
    fit_sensor,
)
from app.features.lab.model_fits.likelihood import FitError
from app.features.lab.model_fits.range_pairs import RangePairs
from robot.geometry import Array

NAMES = [one.name for one in fields(SensorValues)]
KNOWN = SensorValues(0.8, 0.08, 0.05, 0.07, 0.003, 5.0)
CAMERA = (0.17, 0.8)
"""Where the rays of a camera begin and end to see [m]."""


def drawn(
    values: SensorValues = KNOWN, count: int = 3000, seed: int = 0, **more: Any
) -> RangePairs:
    return draw_ranges(values, count, np.random.default_rng(seed), **more)


def rays(measured: list[float], expected: list[float]) -> RangePairs:
    """Rays that see up to 1 m."""
    count, z = len(measured), np.array(expected)
    return RangePairs(
        np.array(measured),
        z,
        np.zeros(count),
        np.zeros(count, dtype=int),
        np.arange(count),
        np.isfinite(z),
        np.tile([0.0, 1.0], (count, 1)),
    )


def inside(fit: SensorFit, true: SensorValues) -> dict[str, bool]:
    found = fit.intervals
    return {name: found[name][0] <= value <= found[name][1] for name, value in asdict(true).items()}


def sizes(fit: SensorFit) -> Array:
    """Widths (6,) of the intervals, of log-odds or logarithms."""
    low, high = np.array([fit.intervals[name] for name in NAMES]).T
    odds = [logit(ends[:4]) for ends in (low, high)]
    return np.concatenate([odds[1] - odds[0], np.log(high[4:] / low[4:])])


# --- the likelihood, by hand


def likelihood(measured: float, expected: float, values: SensorValues, **sight: Any) -> float:
    pairs = replace(rays([measured], [expected]), **sight)
    return math.exp(-beam_loss(pairs, 1.0)(np.array(astuple(values)[1:]))[0])


def by_hand(z: float, expected: float, v: SensorValues) -> float:
    """Of a ray that sees from 0 to 1 m."""
    end = min(expected, 1.0)
    on = 1 - v.z_rand - v.z_short * (1 - math.exp(-v.lambda_short * end))
    straight = v.z_hit / (v.z_hit + v.z_max)
    if z == math.inf:
        return on * (1 - straight) if expected <= 1 else on
    density = v.z_rand
    if z <= expected:
        density += v.z_short * v.lambda_short * math.exp(-v.lambda_short * z)
    if expected <= 1:
        off = (z - expected) / v.sigma_hit
        density += on * straight * math.exp(-(off**2) / 2) / (v.sigma_hit * math.sqrt(2 * math.pi))
    return density


@pytest.mark.parametrize("expected", [0.5, math.inf])
@pytest.mark.parametrize("z", [0.1, 0.497, 0.5, 0.502, 0.9, math.inf])
def test_the_likelihood_is_the_formula(z: float, expected: float) -> None:
    assert likelihood(z, expected, KNOWN) == pytest.approx(by_hand(z, expected, KNOWN))


@pytest.mark.parametrize("expected", [0.5, math.inf])
@pytest.mark.parametrize("sight", [(0.0, 1.0), (0.2, 0.8)])
def test_ranges_and_none_add_up_to_one(expected: float, sight: tuple[float, float]) -> None:
    """So it is a distribution, whatever the ray sees."""
    seen = np.array([sight])
    returned, _ = quad(
        lambda z: likelihood(z, expected, KNOWN, sight=seen), *sight, points=[0.49, 0.5, 0.51]
    )
    assert returned + likelihood(math.inf, expected, KNOWN, sight=seen) == pytest.approx(1, 1e-6)


def test_rays_without_an_edge_in_sight_say_nothing_of_hits_and_misses() -> None:
    """Only of what is false, however z_hit and z_max are divided."""
    other = replace(KNOWN, z_hit=0.5, z_max=0.35, sigma_hit=0.1)
    for z in (0.1, 0.8, math.inf):
        assert likelihood(z, math.inf, KNOWN) == pytest.approx(likelihood(z, math.inf, other))
    more = replace(KNOWN, z_hit=0.75, z_rand=0.12)
    assert likelihood(math.inf, math.inf, more) < likelihood(math.inf, math.inf, KNOWN)
    assert likelihood(0.8, math.inf, more) > likelihood(0.8, math.inf, KNOWN)


def test_rays_at_the_border_of_their_sight_are_left_out() -> None:
    pairs = drawn(count=500)
    unsure = replace(pairs, sure=pairs.sure & (pairs.expected < 0.5))
    left = (pairs.expected < 0.5) | pairs.empty
    assert fit_sensor(unsure, 1.0).rays == left.sum()


def test_slopes_are_those_of_the_likelihood() -> None:
    loss = beam_loss(drawn(sight=CAMERA), 1.0)
    place = np.array(astuple(replace(KNOWN, z_hit=0.7, z_rand=0.17))[1:])
    steps = 1e-7 * np.eye(5)
    differences = [loss(place + step)[0] - loss(place - step)[0] for step in steps]
    found = loss(place)[1]
    np.testing.assert_allclose(found, np.array(differences) / 2e-7, rtol=1e-4, atol=1e-2)


# --- known values are found


@pytest.mark.slow
@pytest.mark.parametrize(
    ("values", "sight"),
    [(KNOWN, (0.0, 1.0)), (SensorValues(0.75, 0.12, 0.05, 0.08, 0.002, 4.0), CAMERA)],
)
def test_known_values_are_in_their_intervals_in_90_of_100_trials(
    values: SensorValues, sight: tuple[float, float]
) -> None:
    fits = [fit_sensor(drawn(values, 4000, seed, sight=sight), 1.0) for seed in range(100)]
    hits = {name: sum(inside(fit, values)[name] for fit in fits) for name in NAMES}
    assert min(hits.values()) >= 90, hits
    assert all(fit.converged for fit in fits)


def test_intervals_are_no_wider_than_they_have_to_be() -> None:
    """They are four times as wide as the estimates spread over many draws."""
    fits = [fit_sensor(drawn(seed=seed), 1.0) for seed in range(60)]
    for name in NAMES:
        spread = np.std([getattr(fit.values, name) for fit in fits], ddof=1)
        told = np.median([np.ptp(fit.intervals[name]) for fit in fits]) / (2 * 1.96)
        assert 0.75 < told / spread < 1.33, name


def test_it_ends_where_it_ends_from_wherever_it_starts() -> None:
    pairs = drawn()
    here = fit_sensor(pairs, 1.0)
    there = fit_sensor(pairs, 1.0, SensorValues(0.25, 0.25, 0.25, 0.25, 0.02, 20.0))
    np.testing.assert_allclose(astuple(there.values), astuple(here.values), rtol=0.01)
    again = fit_sensor(pairs, 1.0, here.values)
    assert again.iterations < here.iterations
    assert again.log_likelihood == pytest.approx(here.log_likelihood, abs=1e-4)


def test_the_range_is_no_matter() -> None:
    """Ten times all lengths is the same fit, in other units."""
    pairs = drawn()
    large = replace(
        pairs, measured=10 * pairs.measured, expected=10 * pairs.expected, sight=10 * pairs.sight
    )
    one, ten = fit_sensor(pairs, 1.0), fit_sensor(large, 10.0)
    scale = np.array([1, 1, 1, 1, 10, 0.1])
    np.testing.assert_allclose(astuple(ten.values), scale * astuple(one.values), rtol=1e-4)
    ends = [np.array(list(fit.intervals.values())) for fit in (one, ten)]
    np.testing.assert_allclose(ends[1], scale[:, None] * ends[0], rtol=1e-3)


def test_rays_that_are_worth_less_widen_intervals_and_change_no_value() -> None:
    whole, part = (fit_sensor(drawn(count=10_000), 1.0, worth=worth) for worth in (1.0, 0.25))
    assert part.values == whole.values
    np.testing.assert_allclose(sizes(part) / sizes(whole), 2.0)


# --- what has a border, or nothing to fit


def test_ranges_that_are_all_right_have_shares_at_the_border() -> None:
    rng = np.random.default_rng(0)
    expected = rng.uniform(0.2, 0.9, 1000)
    fit = fit_sensor(rays((expected + rng.normal(0, 0.002, 1000)).tolist(), expected.tolist()), 1.0)
    assert fit.values.z_hit == pytest.approx(1)
    assert fit.values.sigma_hit == pytest.approx(0.002, rel=0.1)
    assert set(fit.at_border) == {"z_short", "z_max", "z_rand", "lambda_short"}
    for name in ("z_short", "z_max", "z_rand"):
        low, high = fit.intervals[name]
        assert low == 0
        # The rule of three, and more where some of a share is out of sight.
        assert 2.9e-3 < high < 1.2e-2, name
    assert fit.intervals["lambda_short"] == (0, math.inf)
    assert 0.97 < fit.intervals["z_hit"][0] < 0.999


@pytest.mark.parametrize("name", ["z_short", "z_rand"])
def test_a_share_that_is_not_there_has_an_interval_from_zero(name: str) -> None:
    none = replace(KNOWN, **{name: 0.0, "z_hit": KNOWN.z_hit + getattr(KNOWN, name)})
    fits = [fit_sensor(drawn(none, 800, seed), 1.0) for seed in range(10)]
    assert sum(fit.intervals[name][0] == 0 for fit in fits) >= 9
    assert all(fit.intervals[name][1] < 0.1 for fit in fits)


def test_exact_ranges_have_the_least_spread_there_is() -> None:
    fit = fit_sensor(rays([0.5] * 100, [0.5] * 100), 1.0)
    assert fit.values.sigma_hit == pytest.approx(1e-6)
    assert "sigma_hit" in fit.at_border


def test_a_least_spread_is_kept_and_the_rest_fitted_to_it() -> None:
    """A wide normal distribution explains what a narrow one leaves to chance."""
    rng = np.random.default_rng(0)
    expected = rng.uniform(0.2, 0.9, 3000)
    off = 0.0002 * rng.standard_t(2, 3000)
    pairs = rays((expected + off).tolist(), expected.tolist())
    narrow, wide = fit_sensor(pairs, 1.0), fit_sensor(pairs, 1.0, least_sigma=0.001)
    assert wide.values.sigma_hit == 0.001
    assert wide.intervals["sigma_hit"] == (0, 0.001)
    assert wide.values.z_rand < narrow.values.z_rand / 2


def test_ranges_that_nothing_can_be_fitted_to_are_refused() -> None:
    for pairs, message in [
        (drawn(count=20), "rays surely see an edge; needed are 30 or more"),
        (rays([math.inf] * 50, [0.5] * 50), "0 rays returned something where an edge is"),
        (rays([0.5] * 50, [math.inf] * 50), "0 rays surely see"),
    ]:
        with pytest.raises(FitError, match=message):
            fit_sensor(pairs, 1.0)


@pytest.mark.slow
@pytest.mark.parametrize("count", [100, 500, 3000])
@pytest.mark.parametrize("seed", range(8))
def test_ranges_of_another_place_are_refused(count: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    measured, expected = rng.uniform(0, 1, (2, count))
    with pytest.raises(FitError, match="no edge is found"):
        fit_sensor(rays(measured.tolist(), expected.tolist()), 1.0)
