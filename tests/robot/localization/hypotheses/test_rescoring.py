"""A place is judged by the whole way back, followed with odometry that errs."""

from __future__ import annotations

import math

import numpy as np
import pytest
from stub_drive import DEFAULTS, ENTRIES, PERIOD, SENSOR, STUB, Drive, near

from robot import ray_columns as column
from robot.geometry import Array, Pose2, Twist2, compose, pose_covariance
from robot.localization.filter import Setup
from robot.localization.hypotheses.local_map import LocalMap
from robot.localization.hypotheses.rescoring import (
    START_INFORMATION,
    Rescored,
    ScanHistory,
    _moved,
    rescore,
)

SETUP = Setup.of(STUB, ENTRIES, DEFAULTS.motion.model(), SENSOR, DEFAULTS)
GOOD = 0.5
"""So little less than the best there is, as log-likelihood a ray."""


def way(
    start: Pose2, seconds: float = 1.5, turns: float = 1.02, twist: Twist2 = Twist2(0.15, 0.79)
) -> tuple[ScanHistory, Pose2]:
    """The past of a drive whose odometry turns too far, and where it ended."""
    local, drive = LocalMap(0.009, 0.05, 24), Drive(start)
    for _ in range(round(seconds / PERIOD)):
        drive.step(twist)
        local.move(Twist2(1.01 * twist.v, turns * twist.omega).integrate(PERIOD))
        local.add(drive.scan())
    return local.past(8, 30, SETUP.motion), drive.true @ local.since.inverse()


def lacks(found: Rescored, past: ScanHistory) -> Array:
    """How much worse each scan fits than if all its ends lay just on the edges that are due."""
    evidence = SETUP.evidence
    ranges = past.rays[..., column.RANGE]
    best = [evidence.log_peaks(each[np.isfinite(each)]).sum() for each in ranges]
    lacking: Array = np.array(best) / past.rays.shape[1] - found.fits
    return lacking


def life(pose: Pose2, past: ScanHistory) -> Rescored:
    return rescore(pose, past, SETUP.matcher, SETUP.evidence)


STARTS = [Pose2(), Pose2(0.1, 0.25, -0.9), Pose2(-0.1, -0.2, 2.0), Pose2(-0.2, 0.1, 3.1)]


@pytest.mark.parametrize("start", STARTS, ids=str)
def test_at_the_truth_all_scans_fit_though_odometry_errs(start: Pose2) -> None:
    past, end = way(start)
    found = life(end, past)
    assert found.fits.shape == (8,)
    assert lacks(found, past).max() < GOOD
    assert near(found.pose, end, 0.01, 0.02)


@pytest.mark.parametrize("start", STARTS[:3], ids=str)
def test_laid_out_by_odometry_alone_they_would_not(start: Pose2) -> None:
    """So it is the filter on the way back that makes them fit."""
    past, end = way(start, turns=1.1)
    stiff = ScanHistory(past.moves, past.noise * 1e-9, past.rays)
    assert lacks(life(end, past), past).max() < GOOD
    assert life(end, stiff).fits[-1] < life(end, past).fits[-1] - 0.5


def test_a_place_is_found_again_from_centimetres_off() -> None:
    past, end = way(STARTS[1])
    off = end @ Pose2(0.015, -0.01, 0.04)
    found = life(off, past)
    assert found.pose.distance_to(end) < 0.4 * off.distance_to(end)
    assert abs(found.pose.turn_to(end)) < 0.01
    assert lacks(found, past).max() < GOOD


def turned_fits(end: Pose2, past: ScanHistory) -> list[Array]:
    """At the three places that look like the true one but for the stub."""
    quarters = [Pose2(0, 0, turn) for turn in (math.pi / 2, math.pi, -math.pi / 2)]
    return [life(quarter @ end, past).fits for quarter in quarters]


@pytest.mark.parametrize("start", STARTS[:2], ids=str)
def test_where_the_stub_was_seen_places_without_it_fit_worse(start: Pose2) -> None:
    past, end = way(start)
    for fits in turned_fits(end, past):
        assert fits.sum() < life(end, past).fits.sum() - 1


@pytest.mark.parametrize("start", STARTS[2:], ids=str)
def test_where_it_is_neither_seen_nor_due_a_turned_place_fits_as_well(start: Pose2) -> None:
    past, end = way(start)
    true, turned = life(end, past).fits, turned_fits(end, past)
    np.testing.assert_allclose(max(turned, key=np.sum), true, atol=1e-3)
    # Another of them would have seen it.
    assert min(fits.sum() for fits in turned) < true.sum() - 1


def test_a_mark_seen_long_ago_tells_in_the_scans_that_saw_it() -> None:
    """First the robot looks at the stub, then it turns away."""
    past, end = way(Pose2(-0.1, 0.1, -0.3), 1.2, twist=Twist2(0.05, 1.0))
    wrong = life(Pose2(0, 0, math.pi) @ end, past).fits
    told = life(end, past).fits - wrong
    assert told[-1] > 0.5, "the oldest is the last"
    np.testing.assert_allclose(told[:3], 0, atol=1e-3)


def test_elsewhere_nothing_fits() -> None:
    past, end = way(STARTS[0])
    for off in (Pose2(0.2, 0.1, 0.5), Pose2(-0.15, 0, 1.0), Pose2(0, 0.2, -2.0)):
        assert lacks(life(end @ off, past), past).mean() > GOOD + 1


def test_the_covariance_is_that_of_the_newest_scan_on_what_a_found_place_is_worth() -> None:
    past, end = way(STARTS[1])
    found = life(end, past)
    match = SETUP.matcher.match(end, past.rays[0], START_INFORMATION)
    assert found.pose == match.pose
    np.testing.assert_allclose(found.covariance, np.linalg.inv(match.information), rtol=1e-6)
    assert (np.diag(found.covariance) <= 1 / np.diag(START_INFORMATION) + 1e-12).all()


def test_one_scan_is_a_past() -> None:
    past, end = way(STARTS[0])
    short = ScanHistory(past.moves[:1], past.noise[:1], past.rays[:1])
    assert life(end, short).fits == pytest.approx(life(end, past).fits[:1])


def test_blind_it_follows_odometry_back_and_fits_nowhere_better() -> None:
    """No returns: where nothing is due that is as it should be; nothing becomes infinite."""
    past, _ = way(STARTS[0])
    blind = past.rays.copy()
    blind[:, :, 3] = np.inf
    outside = Pose2(0.7, 0.7, 0.8)
    found = life(outside, ScanHistory(past.moves, past.noise, blind))
    assert found.pose == outside
    np.testing.assert_allclose(found.covariance, np.linalg.inv(START_INFORMATION))
    assert np.isfinite(found.fits).all()


@pytest.mark.parametrize("heading", [0.0, 1.2, -2.8])
def test_a_step_back_spreads_as_draws_of_pose_and_step_do(heading: float) -> None:
    rng, step = np.random.default_rng(0), Pose2(-0.3, 0.1, 0.4)
    pose = Pose2(0.1, 0.2, heading)
    covariance = np.array([[4e-4, 1e-4, 0], [1e-4, 2e-4, 0], [0, 0, 1e-3]])
    noise = np.array([[9e-4, 0, 1e-4], [0, 1e-5, 0], [1e-4, 0, 4e-4]])
    draws = compose(
        rng.multivariate_normal(pose.to_array(), covariance, 40_000),
        rng.multivariate_normal(step.to_array(), noise, 40_000),
    )
    found, information = _moved(pose.to_array(), np.linalg.inv(covariance), step.to_array(), noise)
    there = pose @ step
    assert near(Pose2.from_array(found), there, 1e-12, 1e-12)
    wanted = pose_covariance(draws, np.ones(len(draws)), there)
    np.testing.assert_allclose(np.linalg.inv(information), wanted, atol=3e-5)
