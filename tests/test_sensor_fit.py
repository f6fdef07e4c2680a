"""The fit of the beam model finds the values that ranges were drawn with, and how sure it is."""

from __future__ import annotations

import math
from dataclasses import asdict, astuple, fields, replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad
from sensor_draws import draw_ranges

from app.lab.model_fits.fit_error import FitError
from app.lab.model_fits.sensor.climb import coordinates, values_at
from app.lab.model_fits.sensor.fit import SensorFit, fit_sensor
from app.lab.model_fits.sensor.intervals import _gradient
from app.lab.model_fits.sensor.mixture import FitRays, SensorValues, expect
from app.lab.model_fits.sensor.range_pairs import RangePairs

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
    found = {name: fit.interval(name) for name in NAMES}
    return {name: found[name][0] <= value <= found[name][1] for name, value in asdict(true).items()}


# --- the likelihood, by hand


def likelihood(measured: float, expected: float, values: SensorValues, **sight: Any) -> float:
    pairs = replace(rays([measured], [expected]), **sight)
    return math.exp(expect(FitRays.of(pairs, 1.0), values).log_likelihood)


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
    fitted = FitRays.of(drawn(sight=CAMERA), 1.0)
    place = coordinates(replace(KNOWN, z_hit=0.7, z_rand=0.17))
    steps = 1e-5 * np.eye(5)
    differences = [
        expect(fitted, values_at(place + step)).log_likelihood
        - expect(fitted, values_at(place - step)).log_likelihood
        for step in steps
    ]
    found = _gradient(fitted, values_at(place))
    np.testing.assert_allclose(found, np.array(differences) / 2e-5, rtol=1e-4, atol=1e-2)


@given(st.lists(st.floats(-5, 5), min_size=5, max_size=5))
def test_coordinates_and_values_are_each_others_inverse(place: list[float]) -> None:
    np.testing.assert_allclose(coordinates(values_at(np.array(place))), place, atol=1e-9)
    assert sum(astuple(values_at(np.array(place)))[:4]) == pytest.approx(1)


# --- known values are found


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
    """Standard errors are the spread of the estimates over many draws."""
    fits = [fit_sensor(drawn(seed=seed), 1.0) for seed in range(60)]
    for name in NAMES:
        spread = np.std([getattr(fit.values, name) for fit in fits], ddof=1)
        told = np.median([getattr(fit.standard_errors, name) for fit in fits])
        assert 0.75 < told / spread < 1.33, name


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=15, deadline=None)
def test_the_likelihood_never_falls(seed: int) -> None:
    rng = np.random.default_rng(seed)
    shares = rng.dirichlet([9, 1, 1, 1])
    values = SensorValues(*shares.tolist(), rng.uniform(0.001, 0.004), rng.uniform(2, 15))
    pairs = draw_ranges(values, 400, rng, CAMERA if rng.random() < 0.5 else (0.0, 1.0))
    rises = np.diff(fit_sensor(pairs, 1.0).log_likelihoods)
    assert rises.min() > -1e-7


def test_it_ends_where_it_ends_from_wherever_it_starts() -> None:
    pairs = drawn()
    here = fit_sensor(pairs, 1.0)
    there = fit_sensor(pairs, 1.0, SensorValues(0.25, 0.25, 0.25, 0.25, 0.02, 20.0))
    np.testing.assert_allclose(astuple(there.values), astuple(here.values), rtol=0.01)
    again = fit_sensor(pairs, 1.0, here.values)
    assert again.iterations < here.iterations
    assert again.log_likelihoods[-1] == pytest.approx(here.log_likelihoods[-1], abs=1e-4)


def test_the_range_is_no_matter() -> None:
    """Ten times all lengths is the same fit, in other units."""
    pairs = drawn()
    large = replace(
        pairs, measured=10 * pairs.measured, expected=10 * pairs.expected, sight=10 * pairs.sight
    )
    one, ten = fit_sensor(pairs, 1.0), fit_sensor(large, 10.0)
    scale = np.array([1, 1, 1, 1, 10, 0.1])
    np.testing.assert_allclose(astuple(ten.values), scale * astuple(one.values), rtol=1e-4)
    np.testing.assert_allclose(astuple(ten.high), scale * astuple(one.high), rtol=1e-3)


def test_rays_that_are_worth_less_widen_intervals_and_change_no_value() -> None:
    whole, part = (fit_sensor(drawn(count=10_000), 1.0, worth=worth) for worth in (1.0, 0.25))
    assert part.values == whole.values
    errors = np.array(astuple(part.standard_errors)) / astuple(whole.standard_errors)
    np.testing.assert_allclose(errors, 2.0)


# --- what has a border, or nothing to fit


def test_ranges_that_are_all_right_have_shares_at_the_border() -> None:
    rng = np.random.default_rng(0)
    expected = rng.uniform(0.2, 0.9, 1000)
    fit = fit_sensor(rays((expected + rng.normal(0, 0.002, 1000)).tolist(), expected.tolist()), 1.0)
    assert fit.values.z_hit == pytest.approx(1)
    assert fit.values.sigma_hit == pytest.approx(0.002, rel=0.1)
    assert set(fit.at_border) == {"z_short", "z_max", "z_rand", "lambda_short"}
    for name in ("z_short", "z_max", "z_rand"):
        low, high = fit.interval(name)
        assert low == 0
        # The rule of three, and more where some of a share is out of sight.
        assert 2.9e-3 < high < 1.2e-2, name
    assert fit.interval("lambda_short") == (0, math.inf)
    assert 0.97 < fit.interval("z_hit")[0] < 0.999


@pytest.mark.parametrize("name", ["z_short", "z_rand"])
def test_a_share_that_is_not_there_has_an_interval_from_zero(name: str) -> None:
    none = replace(KNOWN, **{name: 0.0, "z_hit": KNOWN.z_hit + getattr(KNOWN, name)})
    fits = [fit_sensor(drawn(none, 800, seed), 1.0) for seed in range(10)]
    assert sum(fit.interval(name)[0] == 0 for fit in fits) >= 9
    assert all(fit.interval(name)[1] < 0.1 for fit in fits)


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
    assert wide.interval("sigma_hit") == (0, 0.001)
    assert wide.values.z_rand < narrow.values.z_rand / 2


def test_ranges_that_nothing_can_be_fitted_to_are_refused() -> None:
    for pairs, message in [
        (drawn(count=20), "rays surely see an edge; needed are 30 or more"),
        (rays([math.inf] * 50, [0.5] * 50), "0 rays returned something where an edge is"),
        (rays([0.5] * 50, [math.inf] * 50), "0 rays surely see"),
        (rays([0.5] * 49 + [math.nan], [0.5] * 50), "nan"),
        (rays([0.5] * 49 + [1.5], [0.5] * 50), "not within 0 and range_max"),
        (rays([-0.1] * 50, [0.5] * 50), "not within 0 and range_max"),
    ]:
        with pytest.raises(FitError, match=message):
            fit_sensor(pairs, 1.0)


def test_ranges_of_another_place_are_refused() -> None:
    rng = np.random.default_rng(0)
    measured, expected = rng.uniform(0, 1, (2, 500))
    with pytest.raises(FitError, match="no edge is found"):
        fit_sensor(rays(measured.tolist(), expected.tolist()), 1.0)


def test_what_cannot_be_started_from_is_refused() -> None:
    pairs = drawn(count=100)
    for start in (replace(KNOWN, z_hit=0.9), replace(KNOWN, sigma_hit=0.0)):
        with pytest.raises(FitError, match="no start"):
            fit_sensor(pairs, 1.0, start)
    with pytest.raises(FitError, match="worth 0"):
        fit_sensor(pairs, 1.0, worth=0.0)
    with pytest.raises(FitError, match="range_max is -1"):
        fit_sensor(pairs, -1.0)
