"""Regions hold the share of the true ends that they should."""

from __future__ import annotations

import numpy as np
import pytest
from motion_drives import drawn_runs
from places import SHARED

from app.features.lab.model_fits.likelihood import FitError
from app.features.lab.model_fits.motion_fit import MotionFit, fit_drive
from app.features.lab.model_fits.motions import DriveCorrection, cut_at, paired_runs
from app.features.lab.model_fits.regions import (
    HORIZONS,
    Region,
    fit_region,
    held_by,
    repetition,
    share_interval,
    squared_distances,
    usable_horizons,
)
from app.features.lab.model_fits.windows import windows
from app.features.lab.trajectories.reading import read_trajectory
from robot.localization.models.odometry_motion import DifferentialMotion

pytestmark = pytest.mark.slow

MRCLAM = SHARED / "mrclam"
LATE = 0.2
"""By so much the robots of that data set follow what they are told [s]."""

ALPHAS = (0.02, 0.3, 0.05, 0.002)
NONE = ((0.0, 1.0),) * 4
PERFECT = MotionFit(ALPHAS, NONE, 1e-6, 1e-6, 100, 1 / 30)
AS_IT_IS = DriveCorrection()


@pytest.fixture(scope="module")
def drives():
    return drawn_runs(DifferentialMotion(*ALPHAS), 30, 400.0, np.random.default_rng(1))


@pytest.mark.parametrize("horizon", [1.0, 5.0, 20.0])
def test_distances_of_true_ends_are_those_of_normal_errors(drives, horizon):
    distances = squared_distances(windows(drives, horizon), PERFECT)
    assert distances.mean() == pytest.approx(3, rel=0.1)
    # 95 % of three squared normal errors stay below 7.815.
    assert np.mean(distances < 7.815) == pytest.approx(0.95, abs=0.02)


def test_regions_fitted_to_some_drives_hold_their_share_of_others(drives):
    assert usable_horizons(drives[:15]) == (1, 5, 20)
    for horizon in HORIZONS:
        region = fit_region(drives[:15], AS_IT_IS, PERFECT, horizon)
        held = held_by(drives[15:], AS_IT_IS, PERFECT, region)
        assert held.share == pytest.approx(0.95, abs=0.02)
        assert held.judgement == "honest"
        assert region.stretch == pytest.approx(1, abs=0.1)


def test_regions_correct_a_model_that_is_too_sure(drives):
    sure = MotionFit((0.005, 0.075, 0.0125, 0.0005), NONE, 1e-6, 1e-6, 100, 1 / 30)
    for horizon in HORIZONS:
        region = fit_region(drives[:15], AS_IT_IS, sure, horizon)
        assert region.stretch == pytest.approx(2, abs=0.2)
        held = held_by(drives[15:], AS_IT_IS, sure, region)
        assert held.share == pytest.approx(0.95, abs=0.02)


def exact(horizon, stretch=1.0):
    """The region of a perfect model, or one that is wider by a factor."""
    return Region(horizon, 0.95, 7.815 * stretch**2, 20.0, 0.0, 0.0, 0.0)


@pytest.mark.parametrize("horizon", [1.0, 5.0, 20.0])
def test_intervals_of_single_drives_hold_the_true_share(drives, horizon):
    found = [held_by([one], AS_IT_IS, PERFECT, exact(horizon)) for one in drives]
    right = sum(one.interval[0] <= 0.95 <= one.interval[1] for one in found)
    assert right >= 28
    assert sum(one.judgement == "honest" for one in found) == right
    assert all(one.independent <= 400 / horizon + 1 for one in found)


@pytest.mark.parametrize("horizon", [1.0, 5.0])
def test_regions_of_another_width_are_told_as_too_sure_and_too_cautious(drives, horizon):
    narrow = held_by(drives, AS_IT_IS, PERFECT, exact(horizon, 0.8))
    wide = held_by(drives, AS_IT_IS, PERFECT, exact(horizon, 1.3))
    assert (narrow.judgement, wide.judgement) == ("too sure", "too cautious")


def test_all_of_few_windows_are_no_certainty():
    assert share_interval(1.0, 20.0) == (pytest.approx(0.025 ** (1 / 20)), 1.0)
    assert share_interval(0.0, 20.0) == (0.0, pytest.approx(1 - 0.025 ** (1 / 20)))
    low, high = share_interval(0.95, 400.0)
    assert (low, high) == (pytest.approx(0.9238, abs=1e-3), pytest.approx(0.9692, abs=1e-3))


@pytest.mark.parametrize("stays", [0.5, 0.9, 0.98])
def test_what_lasts_is_worth_less(stays):
    """A chain that keeps its state with this chance, or else draws anew: rho_k = stays^k."""
    rng = np.random.default_rng(2)
    drives = []
    for _ in range(20):
        anew = rng.random(4000) >= stays
        anew[0] = True
        drives.append((rng.random(4000) < 0.9)[np.maximum.accumulate(np.arange(4000) * anew)])
    assert repetition(drives) == pytest.approx((1 + stays) / (1 - stays), rel=0.15)


def test_widths_are_the_spread_of_the_ends(drives):
    region = fit_region(drives, AS_IT_IS, PERFECT, 5.0)
    spread = windows(drives, 5.0).errors.std(axis=0)
    assert (region.sd_along, region.sd_across, region.sd_heading) == pytest.approx(spread, rel=0.1)


def test_a_threshold_takes_so_many_windows(drives):
    short = [drives[0].part(0, 3000)]
    assert usable_horizons(short) == (1.0, 5.0)
    with pytest.raises(FitError, match="it takes 10: 200 s of driving"):
        fit_region(short, AS_IT_IS, PERFECT, 20.0)


@pytest.mark.data
@pytest.mark.skipif(not MRCLAM.is_dir(), reason="needs the recordings of MRCLAM")
@pytest.mark.parametrize("robot", [1, 2])
def test_regions_of_a_real_robot_hold_on_the_second_half_of_its_drive(robot):
    odometry, truth = (
        read_trajectory(MRCLAM / f"ds6_Robot{robot}_{what}.dat.gz")
        for what in ("Odometry", "Groundtruth")
    )
    runs = paired_runs(odometry.stamps, odometry.poses, truth.stamps, truth.poses, offset=LATE)
    first, second = cut_at(runs, (runs[0].stamps[0] + runs[-1].stamps[-1]) / 2)
    fit = fit_drive(first)
    for horizon in HORIZONS:
        region = fit_region(first, fit.correction, fit.motion, horizon)
        held = held_by(second, fit.correction, fit.motion, region)
        assert 0.92 <= held.share <= 0.98, f"{held.share:.3f} over {region.horizon:g} s"
        assert held.interval[0] < held.share < held.interval[1]
        assert held.judgement == "honest"
        assert region.sd_across < 0.12 and region.sd_heading < 0.15
