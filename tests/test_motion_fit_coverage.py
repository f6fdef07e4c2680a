"""Regions hold the share of the true ends that they should."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from motion_drives import drawn_runs

from app.model_fits.fit_error import FitError
from app.model_fits.motion.coverage import (
    fit_regions,
    share_held,
    squared_distances,
    usable_horizons,
)
from app.model_fits.motion.drive_correction import DriveCorrection
from app.model_fits.motion.drive_fit import fit_drive
from app.model_fits.motion.fit import MotionFit
from app.model_fits.motion.run import cut_at, paired_runs
from app.model_fits.motion.windows import windows
from app.trajectories.files.reading import read_trajectory
from robot.localization.models.differential_motion import DifferentialMotion

MRCLAM = Path(__file__).parent.parent.parent / "shared" / "data" / "mrclam"
LATE = 0.2
"""By so much the robots of that data set follow what they are told [s]."""

ALPHAS = (0.02, 0.3, 0.05, 0.002)
NONE = ((0.0, 1.0),) * 4
PERFECT = MotionFit(ALPHAS, NONE, 1e-6, 1e-6, 0.0, 100, 1 / 30)
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
    regions = fit_regions(drives[:15], AS_IT_IS, PERFECT)
    assert [region.horizon for region in regions] == [1, 5, 20]
    for region in regions:
        assert share_held(drives[15:], AS_IT_IS, PERFECT, region) == pytest.approx(0.95, abs=0.02)
        assert region.stretch == pytest.approx(1, abs=0.1)


def test_regions_correct_a_model_that_is_too_sure(drives):
    sure = MotionFit((0.005, 0.075, 0.0125, 0.0005), NONE, 1e-6, 1e-6, 0.0, 100, 1 / 30)
    for region in fit_regions(drives[:15], AS_IT_IS, sure):
        assert region.stretch == pytest.approx(2, abs=0.2)
        assert share_held(drives[15:], AS_IT_IS, sure, region) == pytest.approx(0.95, abs=0.02)


def test_widths_are_the_spread_of_the_ends(drives):
    (region,) = fit_regions(drives, AS_IT_IS, PERFECT, horizons=[5.0])
    spread = windows(drives, 5.0).errors.std(axis=0)
    assert (region.sd_along, region.sd_across, region.sd_heading) == pytest.approx(spread, rel=0.1)


def test_a_threshold_takes_so_many_windows(drives):
    short = [drives[0].part(0, 3000)]
    assert usable_horizons(short) == (1.0, 5.0)
    with pytest.raises(FitError, match="it takes 10: 200 s of driving"):
        fit_regions(short, AS_IT_IS, PERFECT)


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
    for region in fit_regions(first, fit.correction, fit.motion):
        held = share_held(second, fit.correction, fit.motion, region)
        assert 0.92 <= held <= 0.98, f"{held:.3f} over {region.horizon:g} s"
        assert region.sd_across < 0.12 and region.sd_heading < 0.15
