"""How many particles there are, and when they are drawn anew."""

from __future__ import annotations

import numpy as np
import pytest
from particle_robot import still, track, tracker_of
from stub_drive import DEFAULTS, STUB, Drive, draw_poses

from robot.localization.filter import Cloud


def test_with_certainty_the_number_of_particles_falls() -> None:
    f, drive = tracker_of(), Drive()
    f.set_pose(drive.true)
    assert len(f.cloud.poses) == DEFAULTS.filter.max_particles
    track(f, drive, 2.0)
    assert len(f.cloud.poses) == DEFAULTS.filter.min_particles


def test_scattered_over_the_field_it_keeps_as_many_as_it_may() -> None:
    f = tracker_of(max_particles=3000)
    f.set_cloud(Cloud.even(STUB.free_poses(np.random.default_rng(0), 3000)))
    still(f)
    assert 2000 < len(f.cloud.poses) <= 3000


def test_limits_of_the_number_hold_whatever_the_formula_wants() -> None:
    for least, most in ((700, 900), (2000, 2000), (800, 100)):
        f, drive = tracker_of(min_particles=least, max_particles=most), Drive()
        f.set_pose(drive.true)
        for _ in track(f, drive, 0.5):
            assert least <= len(f.cloud.poses) <= max(least, most)


def test_it_resamples_as_often_as_asked() -> None:
    f, drive = tracker_of(resample_interval=5), Drive()
    f.told(drive.true, 0.02, 0.05)
    even = []
    for _, scan in drive.eight(0.4):
        f.update(drive.odometry, scan)
        even.append(np.ptp(f.cloud.weights) == 0)
    assert even == [(i + 1) % 5 == 0 for i in range(len(even))]


def test_every_scan_between_two_resamplings_counts_and_enough_particles_stay() -> None:
    f, drive = tracker_of(resample_interval=5, min_particles=4000), Drive()
    f.told(drive.true, 0.02, 0.05)
    least = DEFAULTS.filter.min_effective * 4000
    for tick, (_, scan) in enumerate(drive.eight(2.0)):
        before = f.cloud.weights
        f.update(drive.odometry, scan)
        after = f.filter.cloud.weights
        assert np.ptp(after / before) > 0.01, f"scan {tick} changed nothing"
        assert f.filter.effective >= least * (1 - 1e-9)


@pytest.mark.parametrize("interval", [1, 5])
def test_of_given_particles_of_which_few_count_a_scan_still_tells(interval: int) -> None:
    f, drive = tracker_of(resample_interval=interval), Drive()
    poses = draw_poses(np.random.default_rng(0), drive.true, (0.02, 0.02, 0.05), 4000)
    weights = np.where(np.arange(4000) < 100, 1.0, 1e-6)
    f.set_cloud(Cloud(poses, weights / weights.sum()))
    before = f.filter.effective
    assert before < DEFAULTS.filter.min_effective * 4000
    f.update(drive.odometry, drive.scan())
    assert f.filter.effective < 0.9 * before


def test_selective_it_resamples_only_when_few_particles_count() -> None:
    f, drive = tracker_of(selective_resampling=True), Drive()
    f.told(drive.true, 0.02, 0.05)
    kept = 0
    for _, scan in drive.eight(2.0):
        f.update(drive.odometry, scan)
        few = (1 / np.square(f.filter.cloud.weights).sum()) < 0.5 * len(f.filter.cloud.weights)
        assert few == (np.ptp(f.cloud.weights) == 0)
        kept += not few
    assert kept > 10
