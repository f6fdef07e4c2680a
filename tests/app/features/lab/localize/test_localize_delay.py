"""Scans that are stamped late: noticed by how they fit odometry, and used when they were made."""

import numpy as np
import pytest
from laser_office import BEGAN, LASER, drive, true_pose
from localize_runs import run
from paired_bags import paired

from benchmarks.lasers.laser_bags import LaserBag
from robot.geometry import Pose2

pytestmark = pytest.mark.slow

SECONDS = 24.0


def write(path, delay, seed=0, arrives_late=True):
    with LaserBag(path, "mcap") as bag:
        bag.transform(BEGAN, "base_link", "laser", LASER.place, topic="/tf_static")
        for each in drive(seconds=SECONDS, seed=seed):
            made = BEGAN + each.stamp
            bag.odometry(made, each.odometry)
            form = {"first": LASER.bearings[0], "step": LASER.step, "reach": (0.05, LASER.reach)}
            logged = made if arrives_late else made - delay
            bag.scan(made - delay, each.ranges, logged=logged, **form)
    return path


@pytest.mark.parametrize("delay", [0.1, 0.3, 1.0, -0.3])
@pytest.mark.parametrize("arrives_late", [True, False])
def test_a_delay_is_measured_told_and_taken_off(tmp_path, delay, arrives_late):
    found, _, remarks = paired(write(tmp_path / "bag", delay, arrives_late=arrives_late))
    late = "later" if delay > 0 else "earlier"
    assert len(remarks) == 1
    assert f"made {abs(delay):.2f} s {late} than their stamps say" in remarks[0]
    by_stamp = {round(BEGAN + each.stamp, 3): each for each in drive(seconds=SECONDS)}
    for each in found[20:-20]:
        nearest = min(by_stamp, key=lambda stamp: abs(stamp - each.scan.stamp))
        assert each.scan.stamp == pytest.approx(nearest, abs=0.02)


@pytest.mark.parametrize("seed", [0, 4, 7, 11])
def test_no_delay_is_invented(tmp_path, seed):
    _, _, remarks = paired(write(tmp_path / "bag", 0.0, seed))
    assert remarks == []


def test_a_late_laser_is_not_followed_beside_the_way(tmp_path):
    found, way = run(tmp_path, write(tmp_path / "bag", 0.5))
    assert found["known"]
    seen = drive(seconds=SECONDS)
    truth = np.array([[BEGAN + each.stamp, *true_pose(each).to_array()[:2]] for each in seen])
    at = [np.interp(way.stamps, truth[:, 0], truth[:, column]) for column in (1, 2)]
    assert np.median(np.hypot(*(way.poses[:, :2].T - at))) < 0.05


def test_a_late_arrival_that_scans_cannot_judge_is_told(tmp_path):
    with LaserBag(tmp_path / "bag", "mcap") as bag:
        for tick in range(100):
            made = BEGAN + 0.1 * tick
            bag.odometry(made, Pose2())
            bag.scan(made - 0.5, [1.0] * 50, first=0.0, step=0.1, logged=made)
    _, _, (words,) = paired(tmp_path / "bag")
    assert "scans arrived 0.50 s later after their stamps than odometry did" in words
    assert "--clock log" in words
