"""Figures of runs whose errors are known, and intervals that hold what they claim."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.features.run_table.figures import FEWEST_BLOCKS, RunSamples, difference_of, figures_of

RATE = 30.0


def samples(errors, *, start=0.0, misleading=0.0) -> RunSamples:
    errors = np.asarray(errors, float)
    stamps = start + np.arange(errors.size) / RATE
    turns = np.where(np.isfinite(errors), 0.0, math.inf)
    return RunSamples(stamps, errors, turns, np.broadcast_to(misleading, errors.shape))


def wandering(rng, level: float, seconds: float) -> np.ndarray:
    """Errors [m] that stay alike for half a second, as those of a filter."""
    drawn = rng.normal(size=round(seconds * RATE))
    for i in range(1, drawn.size):
        drawn[i] = 0.93 * drawn[i - 1] + math.sqrt(1 - 0.93**2) * drawn[i]
    return level * np.abs(drawn)


def test_figures_of_known_errors() -> None:
    figures = figures_of(samples([0.003, 0.004, 0.0, 0.005], misleading=[0, 1, 0, 0]))
    assert figures is not None
    assert figures.rmse == pytest.approx(math.sqrt(50 / 4) * 1e-3)
    assert (figures.median, figures.worst) == pytest.approx((0.0035, 0.005))
    assert (figures.lost, figures.misleading, figures.pictures) == (0.0, 0.25, 4)
    assert figures.seconds == pytest.approx(3 / RATE)


def test_pictures_without_an_estimate_are_lost_and_have_no_error() -> None:
    figures = figures_of(samples([math.inf] * 30 + [0.002] * 90))
    assert figures is not None
    assert (figures.rmse, figures.lost) == pytest.approx((0.002, 0.25))
    assert figures.time_to_right == pytest.approx(1.0)
    nothing = figures_of(samples([math.inf] * 3))
    assert nothing is not None
    assert (nothing.rmse, nothing.lost, nothing.time_to_right) == (None, 1.0, None)
    assert figures_of(samples([])) is None


def test_a_moment_of_being_right_is_not_yet_right() -> None:
    figures = figures_of(samples([0.2] * 30 + [0.01] * 15 + [0.2] * 15 + [0.01] * 60))
    assert figures is not None
    assert figures.time_to_right == pytest.approx(2.0)


def test_a_wrong_heading_is_not_right() -> None:
    turned = RunSamples(np.arange(2.0), np.zeros(2), np.array([0.0, 0.2]), np.zeros(2))
    figures = figures_of(turned)
    assert figures is not None
    assert figures.lost == 0.5


def test_the_same_pictures_are_compared_one_by_one() -> None:
    rng = np.random.default_rng(5)
    hard = wandering(rng, 0.004, 40.0)
    first, worse = samples(hard), samples(hard * 1.05)
    paired = difference_of(worse, first)
    apart = difference_of(samples(hard * 1.05, start=500.01), first)
    assert paired is not None and apart is not None
    assert (paired.paired, apart.paired) == (True, False)
    assert paired.rmse == pytest.approx(apart.rmse)
    assert 0 < paired.low < paired.rmse < paired.high
    assert apart.low < 0 < apart.high, "other pictures vary by more than a twentieth"


def test_too_short_a_run_has_no_interval() -> None:
    short = samples([0.001] * round(2 * RATE * (FEWEST_BLOCKS - 1)))
    found = difference_of(short, samples([0.002] * 300))
    assert found is not None
    assert (found.rmse, found.low, found.high) == (pytest.approx(-0.001), None, None)
    assert difference_of(short, samples([math.inf] * 300)) is None


def test_the_interval_holds_the_difference_about_as_often_as_it_says() -> None:
    held, tried = 0, 120
    for seed in range(tried):
        rng = np.random.default_rng(1000 + seed)
        runs = [samples(wandering(rng, 0.004, 60.0), start=start) for start in (0.0, 200.01)]
        found = difference_of(*runs)
        assert found is not None and found.low is not None and found.high is not None
        held += found.low <= 0 <= found.high
    assert held >= 0.87 * tried


@given(st.lists(st.floats(0, 1), min_size=1, max_size=200), st.integers(0, 199))
def test_the_end_of_a_run_is_a_run(errors: list[float], first: int) -> None:
    whole = samples(errors)
    stamp = whole.stamps[min(first, len(errors) - 1)]
    part = figures_of(whole.since(float(stamp)))
    assert part is not None
    figures = figures_of(whole)
    assert figures is not None
    assert part.worst <= figures.worst
    assert part.median <= part.worst
    assert part.rmse <= part.worst * (1 + 1e-9)
