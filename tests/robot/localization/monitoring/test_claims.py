"""What is claimed of an estimate, by its weight, its covariance and what is doubted."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from robot.geometry import Pose2
from robot.localization.estimate import (
    BOUNDED,
    ONLY_PLACE,
    Alert,
    Cause,
    Hypothesis,
    Standing,
    State,
)
from robot.localization.monitoring.claims import (
    HEADING_QUANTILE,
    LEAST_HEADING,
    LEAST_PLACE,
    MAX_RADIUS,
    NARROW,
    PLACE_QUANTILE,
    bounds,
    claim,
    propagate_claim,
)
from robot.localization.monitoring.doubt import NO_DOUBT

SURE = np.diag(np.square([0.001, 0.001, 0.003]))


def places(*weights: float) -> tuple[Hypothesis, ...]:
    return tuple(Hypothesis(weight, Pose2(), SURE) for weight in weights)


@pytest.mark.parametrize(
    ("weights", "standing", "wanted"),
    [
        ((0.999,), Standing.CONFIRMED, State.CERTAIN),
        ((0.999,), Standing.GIVEN, State.GIVEN),
        ((0.999,), Standing.UNCONFIRMED, State.APPROXIMATE),
        ((0.999,), Standing.LOST, State.LOST),
        ((0.6, 0.39), Standing.CONFIRMED, State.AMBIGUOUS),
        ((ONLY_PLACE, 0.04), Standing.CONFIRMED, State.AMBIGUOUS),
        ((ONLY_PLACE + 0.001, 0.04), Standing.CONFIRMED, State.CERTAIN),
        ((0.3, 0.1), Standing.CONFIRMED, State.SEARCHING),
        ((0.3, 0.1), Standing.LOST, State.LOST),
    ],
)
def test_the_state_is_told_by_weights_and_standing(
    weights: tuple[float, ...], standing: Standing, wanted: State
) -> None:
    found = claim(places(*weights), standing, NO_DOUBT)
    assert found.state is wanted
    # Unconfirmed, it may be another place.
    told = wanted in BOUNDED
    assert math.isfinite(found.radius) == told


def test_a_wide_bound_is_approximate_only() -> None:
    for sds, wanted in (
        ((0.015, 0.015, 0.003), State.CERTAIN),
        ((0.025, 0.001, 0.003), State.APPROXIMATE),
        ((0.001, 0.025, 0.003), State.APPROXIMATE),
        ((0.001, 0.001, 0.06), State.APPROXIMATE),
    ):
        one = Hypothesis(1.0, Pose2(), np.diag(np.square(sds)))
        found = claim((one,), Standing.CONFIRMED, NO_DOUBT)
        assert found.state is wanted and math.isfinite(found.radius)


@pytest.mark.parametrize(("share", "wanted"), [(0.99, State.APPROXIMATE), (1.01, State.SEARCHING)])
def test_where_the_bound_is_too_wide_the_place_is_not_known(share: float, wanted: State) -> None:
    sd = share * MAX_RADIUS / PLACE_QUANTILE
    one = Hypothesis(1.0, Pose2(), np.diag(np.square([sd, 0.001, 0.003])))
    found = claim((one,), Standing.CONFIRMED, NO_DOUBT)
    assert found.state is wanted
    assert math.isfinite(found.radius) == (wanted is State.APPROXIMATE)


def test_what_cannot_be_excluded_widens_the_bound() -> None:
    wide = replace(NO_DOUBT, unknown=np.diag(np.square([0.003, 0.0, 0.02])))
    plain, doubted = (claim(places(1.0), Standing.CONFIRMED, doubt) for doubt in (NO_DOUBT, wide))
    assert doubted.radius > 2 * plain.radius and doubted.heading_bound > 4 * plain.heading_bound
    assert plain.state is doubted.state is State.CERTAIN
    wider = replace(NO_DOUBT, unknown=64 * wide.unknown)
    assert claim(places(1.0), Standing.CONFIRMED, wider).state is State.APPROXIMATE


def test_where_scans_do_not_fit_nothing_is_bounded() -> None:
    alerts = (Alert(Cause.MAP, "is it this floor?"),)
    unfit = replace(NO_DOUBT, fits=False, alerts=alerts)
    found = claim(places(1.0), Standing.CONFIRMED, unfit)
    assert found.state is State.APPROXIMATE
    assert found.radius == math.inf and found.heading_bound == math.pi
    assert found.alerts == alerts


@pytest.mark.parametrize("standing", Standing)
def test_reasons_are_told_whatever_the_state(standing: Standing) -> None:
    doubt = replace(NO_DOUBT, alerts=(Alert(Cause.WHEEL_SLIP, "do they slip?"),))
    for weights in ((1.0,), (0.6, 0.4), (0.2,)):
        assert claim(places(*weights), standing, doubt).alerts == doubt.alerts


def test_bounds_hold_in_all_but_a_thousandth_of_draws() -> None:
    rng = np.random.default_rng(0)
    for sds in ((0.003, 0.003), (0.004, 0.0005)):
        turn = np.array([[0.6, -0.8], [0.8, 0.6]])
        place = turn @ np.diag(np.square(sds)) @ turn.T
        covariance = np.zeros((3, 3))
        covariance[:2, :2], covariance[2, 2] = place, 0.01**2
        radius, heading = bounds(covariance)
        drawn = rng.multivariate_normal(np.zeros(3), covariance, 200_000)
        assert (np.hypot(*drawn[:, :2].T) > radius).mean() < 0.0011
        assert (np.abs(drawn[:, 2]) > heading).mean() < 0.0011


def test_no_bound_is_narrower_than_the_scanner_errs() -> None:
    radius, heading = bounds(np.zeros((3, 3)))
    assert radius == pytest.approx(PLACE_QUANTILE * LEAST_PLACE) and radius < NARROW
    assert heading == pytest.approx(HEADING_QUANTILE * LEAST_HEADING)
    assert bounds(np.diag([0.0, 0.0, 100.0]))[1] == math.pi


def test_between_pictures_the_bound_grows_with_the_way() -> None:
    claimed = claim(places(1.0), Standing.CONFIRMED, NO_DOUBT)
    assert propagate_claim(claimed, Pose2()) == claimed
    steps = [propagate_claim(claimed, Pose2(way, 0.0, 2 * way)) for way in (0.005, 0.05, 0.1, 0.5)]
    radii = [claimed.radius, *(each.radius for each in steps)]
    assert radii == sorted(radii) and radii[1] < claimed.radius + 0.001
    assert [each.state for each in steps[1:]] == [State.CERTAIN, State.CERTAIN, State.APPROXIMATE]
    assert steps[-1].heading_bound > claimed.heading_bound + 0.4


def test_what_has_no_bound_stays_as_it_is() -> None:
    for standing in (Standing.LOST, Standing.UNCONFIRMED):
        claimed = claim(places(1.0), standing, NO_DOUBT)
        assert propagate_claim(claimed, Pose2(1, 0, 1)) is claimed
