"""A real robot's pictures of a lane, and the alignment with cameras above the floor."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from app.trajectories.trajectory import Trajectory
from benchmarks.pictures import lane
from benchmarks.pictures.overhead import Overhead, align
from robot.fields.svg_field import load_svg
from robot.geometry import Pose2, Twist2


def overhead_of_a_curve() -> Overhead:
    stamps = 1_574_103_165.0 + np.arange(0, 6, 0.07)
    # On an arc at an even speed, a time shift would be a transform, too.
    pose, poses = Pose2(), []
    for place in range(len(stamps)):
        poses.append(pose.to_array())
        pose = pose @ Twist2(0.3, 1.5 * math.sin(place / 9)).integrate(0.07)
    table = np.array(poses)
    table[:, 2] = np.unwrap(table[:, 2])
    return Overhead(stamps, table)


def test_the_alignment_finds_the_transform_and_the_time_shift() -> None:
    overhead = overhead_of_a_curve()
    stamps = overhead.stamps[10:-10:4]
    moved, late = Pose2(0.05, -0.03, 0.1), 0.12
    seen = [(moved @ Pose2.from_array(pose)).to_array() for pose in overhead.at(stamps)]
    aligned = align(Trajectory.of_poses(stamps + late, seen), overhead)
    assert aligned.shift == pytest.approx(late, abs=0.002)
    assert aligned.moved.theta == pytest.approx(0.1, abs=1e-3)
    assert aligned.distances.max() < 0.001 and aligned.turns.max() < 0.001


def test_one_outlier_is_no_part_of_the_alignment() -> None:
    overhead = overhead_of_a_curve()
    stamps = overhead.stamps[10:-10:4]
    poses = overhead.at(stamps)
    poses[7, 0] += 0.5
    aligned = align(Trajectory.of_poses(stamps, poses), overhead)
    assert aligned.distances[7] == pytest.approx(0.5, abs=0.01)
    assert np.median(aligned.distances) < 0.003


def test_odometry_errs_by_some_percent() -> None:
    overhead = overhead_of_a_curve()
    ways = [overhead.odometry(seed).poses for seed in range(40)]
    length = np.hypot(*np.diff(overhead.poses[:, :2], axis=0).T).sum()
    travelled = [np.hypot(*np.diff(way[:, :2], axis=0).T).sum() for way in ways]
    assert np.std(travelled) / length == pytest.approx(0.03, rel=0.4)
    np.testing.assert_allclose(ways[3], overhead.odometry(3).poses)


def test_the_lane_has_three_lines_of_light_tape() -> None:
    field = load_svg(lane.FIELD)
    assert {(kind.width, kind.light, kind.dash) for kind in field.tape} == {
        (0.048, True, 0.0),
        (0.024, True, 0.05),
    }
    assert field.contains(field.start)


@pytest.mark.slow
@pytest.mark.data
@pytest.mark.skipif(not lane.DATA.is_dir(), reason="needs the lane's sequence")
def test_the_robot_is_followed_along_the_lane(tmp_path: Path) -> None:
    run = lane.run_lane(tmp_path, 0)
    assert run.stale == ("autobot04_1574103167_445264101.jpg",)
    assert (run.pictures, run.lost) == (22, 0)
    assert np.median(run.aligned.distances) < 0.015
    assert np.percentile(run.aligned.distances, 90) < 0.040
    assert np.median(run.aligned.turns) < math.radians(1.6)
    assert np.percentile(run.aligned.turns, 90) < math.radians(4)
