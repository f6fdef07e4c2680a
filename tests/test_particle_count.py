"""How many particles there are, and when they are drawn anew."""

from __future__ import annotations

import numpy as np
from particle_robot import still, track, tracker_of
from stub_drive import DEFAULTS, STUB, Drive

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
    assert len(f.cloud.poses) > 2000


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
