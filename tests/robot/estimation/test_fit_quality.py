"""What an adjustment says for and against its own result."""

import json
import math
from datetime import UTC, datetime

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robot.description.profile import Profile, profile_of
from robot.description.unknowns import PRIORS, ROBOT
from robot.estimation.fit_quality import (
    FEWEST,
    ContradictionError,
    FitQuality,
    correlation_of,
    overruns,
    robust_sd,
)
from robot.toml_file import parse_toml

NAMES = st.from_regex(r"[a-z_]{1,12}", fullmatch=True)
SHARES = st.floats(-99, 99).map(lambda share: round(share, 1))


@given(
    st.floats(0, 50).map(lambda residual: round(residual, 4)),
    st.booleans(),
    st.dictionaries(NAMES, SHARES, max_size=3),
    st.lists(NAMES, max_size=3),
)
def test_a_file_tells_what_the_adjustment_told(
    residual: float, converged: bool, overrun: dict[str, float], unobservable: list[str]
) -> None:
    quality = FitQuality(residual, converged, 0.25, overrun, tuple(unobservable))
    assert FitQuality.of_table(json.loads(json.dumps(quality.table()))) == quality
    made = Profile("spike", datetime.now(UTC), "a test", np.zeros(ROBOT), PRIORS[:ROBOT])
    kept = profile_of(parse_toml(made.to_toml(), "it"))
    assert kept.fit == {}
    text = Profile("spike", made.made, "a test", made.values, made.sd, None, quality.table())
    assert FitQuality.of_table(profile_of(parse_toml(text.to_toml(), "it")).fit) == quality


def test_a_result_that_contradicts_itself_is_refused_unless_somebody_insists() -> None:
    fine = FitQuality(0.45, correlation=0.1, unobservable=("camera_yaw",))
    assert fine.remarks == ()
    fine.require_consistent()
    for wrong, words in (
        (FitQuality(0.45, converged=False), "did not come to an end"),
        (FitQuality(0.45, overrun={"tape_width": -65.0}), "tape_width -65"),
        (FitQuality(2.8), "2.8 times as far off as expected"),
    ):
        with pytest.raises(ContradictionError, match=words):
            wrong.require_consistent()
        wrong.require_consistent(force=True)


@pytest.mark.parametrize("table", [{"overrun": 5.0}, {"overrun": ["far"]}, {"residual": "half"}])
def test_a_table_that_no_adjustment_wrote_says_nothing(table: dict[str, object]) -> None:
    quality = FitQuality.of_table(table)
    assert math.isnan(quality.residual)
    assert quality.remarks == ()


def test_nothing_seen_contradicts_nothing() -> None:
    empty = FitQuality(robust_sd([]), correlation=correlation_of(np.zeros(0)))
    assert math.isnan(empty.residual)
    assert empty.contradictions == ()
    assert empty.interval_factor == 1.0


def test_intervals_hold_what_is_left_over() -> None:
    """Means of coloured noise scatter as the factor says, which the sum of squares hides."""
    rng, alike, count = np.random.default_rng(3), 0.9, 4000
    noise = rng.standard_normal((200, count))
    coloured = np.zeros_like(noise)
    for k in range(1, count):
        coloured[:, k] = alike * coloured[:, k - 1] + math.sqrt(1 - alike**2) * noise[:, k]
    found = correlation_of(coloured[0])
    assert found == pytest.approx(alike, abs=0.03)
    quality = FitQuality(robust_sd(coloured[0]), correlation=found)
    assert not quality.is_noise
    scatter = coloured.mean(axis=1).std() * math.sqrt(count)
    assert quality.interval_factor == pytest.approx(scatter, rel=0.25)
    assert FitQuality(1.0, correlation=correlation_of(noise[0])).interval_factor == 1.0


@pytest.mark.parametrize("alike", [-0.3, 0.0, 0.3, 0.5])
def test_residuals_that_are_alike_count_less_though_they_are_noise(alike: float) -> None:
    quality = FitQuality(1.0, correlation=alike)
    assert quality.is_noise and quality.interval_factor == 1.0
    counting = max(alike, 0.0)
    assert quality.alike_factor == pytest.approx(math.sqrt((1 + counting) / (1 - counting)))


def test_neighbours_are_means_of_pictures_that_saw_enough() -> None:
    groups = np.repeat([0, 1, 2, 5], [FEWEST, FEWEST, 1, FEWEST])
    residuals = np.where(groups == 2, -50.0, 1.0)
    assert correlation_of(residuals, groups) == pytest.approx(2 / 3)


def test_what_leaves_its_prior_is_named_with_how_far() -> None:
    assert overruns([0.1, -4.0, 2.0], [1.0, 1.0, 0.5], ("a", "b", "c")) == {"b": -4.0, "c": 4.0}
