import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.features.lab.evaluation.results import Summary, bootstrap_interval, summary

values = st.lists(st.floats(-1e6, 1e6), min_size=1, max_size=30)


def test_a_summary_is_mean_median_and_largest():
    assert summary([1, 2, 6]) == Summary(3.0, 2.0, 6.0)


@given(values)
def test_the_interval_is_within_the_values_and_the_same_each_time(some):
    low, high = bootstrap_interval(some, draws=200)
    slack = 1e-9 * max(map(abs, some))
    assert min(some) - slack <= low <= high <= max(some) + slack
    assert (low, high) == bootstrap_interval(some, draws=200)


def test_the_interval_is_as_wide_as_theory_says():
    draws = np.random.default_rng(0).normal(5, 2, 400)
    low, high = bootstrap_interval(draws)
    width = 2 * 1.96 * draws.std() / np.sqrt(400)
    assert high - low == pytest.approx(width, rel=0.05)
    assert (low + high) / 2 == pytest.approx(draws.mean(), abs=0.02)


def test_the_interval_holds_the_true_mean_about_as_often_as_it_says():
    """Of 12 values a little less often: the percentile bootstrap is known to be narrow."""
    rng = np.random.default_rng(1)
    held = 0
    for _ in range(300):
        low, high = bootstrap_interval(rng.normal(size=12), draws=1000)
        held += low <= 0 <= high
    assert 0.87 <= held / 300 <= 0.97


def test_many_values_are_drawn_in_parts_as_at_once(monkeypatch):
    some = np.random.default_rng(2).normal(size=50)
    expected = bootstrap_interval(some, draws=1000)
    monkeypatch.setattr("app.features.lab.evaluation.results.DRAW_BATCH", 70)
    assert bootstrap_interval(some, draws=1000) == expected


@pytest.mark.parametrize("some", [[], [1, np.nan], [np.inf]])
def test_values_that_say_nothing_are_refused(some):
    for work in (summary, bootstrap_interval):
        with pytest.raises(ValueError, match="valid are finite numbers"):
            work(some)
