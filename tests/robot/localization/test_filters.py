"""One contract for every filter that can be asked for, and for the textbook's Kalman filter."""

from __future__ import annotations

import math

import numpy as np
import pytest
from filter_makers import NARROW, SDS, START, Make, each_filter, sds
from hypothesis import given, settings
from hypothesis import strategies as st
from stub_drive import (
    BEARINGS,
    Drive,
    check_sound,
    draw_poses,
    follow,
    near,
)

from robot.geometry import Array, Pose2, mean_pose, pose_covariance
from robot.localization.filter import Cloud
from robot.scan import Scan


def spread(cloud: Cloud) -> Array:
    """Standard deviations [m, m, rad] of what is shown."""
    mean = mean_pose(cloud.poses, cloud.weights)
    return sds(pose_covariance(cloud.poses, cloud.weights, mean))


# --- what it is told


@each_filter
def test_a_told_pose_is_the_only_hypothesis_and_as_wide_as_told(make: Make) -> None:
    f = make(0)
    told = Pose2(0.1, -0.05, 3.1)
    f.set_pose(told, NARROW)
    (one,) = f.hypotheses
    assert near(one.pose, told, 0.002, 0.005) and one.weight > 0.99
    np.testing.assert_allclose(sds(one.covariance), SDS, rtol=0.1)
    check_sound(f)
    np.testing.assert_allclose(spread(f.cloud), SDS, rtol=0.1)


@each_filter
def test_a_pose_told_without_a_doubt_is_one_pose_and_can_be_driven_from(make: Make) -> None:
    f, drive = make(0), Drive()
    f.set_pose(drive.true, np.zeros((3, 3)))
    (one,) = f.hypotheses
    assert near(one.pose, drive.true, 0.001, 0.003)
    assert sds(one.covariance).max() < 0.005
    check_sound(f)
    assert max(follow(f, drive, 1.0)) < 0.005
    check_sound(f)


@each_filter
def test_a_given_cloud_is_taken_with_its_mean_and_covariance(make: Make) -> None:
    f = make(0)
    poses = draw_poses(np.random.default_rng(0), Pose2(0.1, 0.1, -3.1), (0.03, 0.02, 0.08), 4000)
    weights = np.random.default_rng(1).random(4000)
    weights /= weights.sum()
    mean, cloud = mean_pose(poses, weights), Cloud(poses, weights)
    f.set_cloud(cloud)
    check_sound(f)
    shown = f.cloud
    assert near(mean_pose(shown.poses, shown.weights), mean, 0.002, 0.005)
    np.testing.assert_allclose(spread(shown), spread(cloud), rtol=0.1)
    assert near(f.hypotheses[0].pose, mean, 0.005, 0.01)


@each_filter
def test_what_was_believed_before_a_pose_was_told_is_forgotten(make: Make) -> None:
    f, told = make(0), Pose2(0.1, 0.1, 1.0)
    f.set_pose(Pose2(-0.3, -0.3, -2.0), NARROW)
    f.predict(Pose2(0.05, 0, 0.3))
    f.set_pose(told, NARROW)
    assert near(f.hypotheses[0].pose, told, 0.002, 0.005)
    np.testing.assert_allclose(sds(f.hypotheses[0].covariance), SDS, rtol=0.1)


@each_filter
def test_scattered_its_cloud_is_all_over_the_field_with_any_heading(make: Make) -> None:
    f = make(0)
    f.scatter()
    check_sound(f)
    poses, weights = f.cloud.poses, f.cloud.weights
    assert np.abs(weights @ poses[:, :2]).max() < 0.04
    for right in (False, True):
        for upper in (False, True):
            here = ((poses[:, 0] > 0) == right) & ((poses[:, 1] > 0) == upper)
            assert 0.15 < weights[here].sum() < 0.35
    for start in np.arange(-4, 4) * math.pi / 4:
        here = (poses[:, 2] >= start) & (poses[:, 2] < start + math.pi / 4)
        assert 0.04 < weights[here].sum() < 0.25


# --- it follows the robot


@each_filter
def test_without_scans_it_follows_odometry_and_gets_less_sure(make: Make) -> None:
    f, drive = make(0), Drive(Pose2(0.1, 0, 0.5))
    f.set_pose(drive.true, np.diag(np.square([0.005, 0.005, 0.01])))
    narrow = f.hypotheses[0].covariance
    for moved, _ in drive.eight(2.0):
        f.predict(moved)
    check_sound(f)
    there, found = Pose2(0.1, 0, 0.5) @ drive.odometry, f.hypotheses[0]
    assert near(found.pose, there, 0.005, 0.02)
    assert found.covariance.trace() > 2 * narrow.trace()


@each_filter
def test_standing_changes_nothing(make: Make) -> None:
    f = make(0)
    f.set_pose(Pose2(0.1, 0.2, 0.3), NARROW)
    before = f.hypotheses[0]
    for _ in range(100):
        f.predict(Pose2())
    after = f.hypotheses[0]
    assert near(after.pose, before.pose, 1e-6, 1e-6)
    np.testing.assert_allclose(after.covariance, before.covariance, rtol=1e-6, atol=1e-9)


@pytest.mark.slow
@each_filter
@pytest.mark.parametrize("robot_from_scan", [Pose2(), Pose2(0.04, 0.02, 0.2)], ids=str)
def test_it_stays_on_the_robot(make: Make, robot_from_scan: Pose2) -> None:
    f, drive = make(0), Drive(robot_from_scan=robot_from_scan)
    f.set_pose(drive.true @ Pose2(0.01, -0.01, 0.03), NARROW)
    errors = follow(f, drive, 4.0)
    assert max(errors[30:]) < 0.01
    assert np.mean(errors[30:]) < 0.003
    found = f.hypotheses[0]
    assert abs(found.pose.turn_to(drive.true)) < 0.02
    assert drive.odometry.distance_to(drive.true) > 0.005, "odometry alone would be off"
    check_sound(f)


@each_filter
def test_it_does_not_claim_to_be_surer_than_it_is(make: Make) -> None:
    """On average of drives; cautious is no fault here, for neighbouring rays may err together."""
    squared = []
    for seed in range(4):
        f, drive = make(seed), Drive(rng=np.random.default_rng(seed))
        f.set_pose(drive.true @ Pose2(0.01, -0.01, 0.03), NARROW)
        follow(f, drive, 1.5)
        one = f.hypotheses[0]
        error = one.pose.to_array() - drive.true.to_array()
        squared.append(error @ np.linalg.solve(one.covariance, error))
    assert np.mean(squared) < 4.3  # 3 for an honest one; more in 1 of 10 of such tests


# --- what a scan may be


@each_filter
@pytest.mark.parametrize("rays", [0, 61], ids=["no rays", "no returns"])
def test_a_scan_of_nothing_says_nothing(make: Make, rays: int) -> None:
    f = make(0)
    f.set_pose(Pose2(0.1, 0.2, 0.3), NARROW)
    before = f.hypotheses[0]
    f.correct(Scan(0.0, BEARINGS[:rays], np.full(rays, np.inf)))
    after = f.hypotheses[0]
    assert near(after.pose, before.pose, 0.002, 0.005)
    np.testing.assert_allclose(after.covariance, before.covariance, atol=6e-5)
    check_sound(f)


@each_filter
def test_what_is_said_of_the_robot_is_new_after_each_scan_and_step(make: Make) -> None:
    f, drive = make(0), Drive()
    f.set_pose(drive.true, NARROW)
    told = f.hypotheses[0]
    f.correct(drive.scan())
    seen = f.hypotheses[0]
    assert seen.covariance[0, 0] < 0.5 * told.covariance[0, 0]
    f.predict(Pose2(0.001))
    assert f.hypotheses[0].pose.distance_to(seen.pose) > 0.0005


@each_filter
def test_a_scan_with_one_return_is_a_scan(make: Make) -> None:
    f, drive = make(0), Drive()
    f.set_pose(drive.true, NARROW)
    ranges = drive.scan().ranges.copy()
    ranges[:30], ranges[31:] = np.inf, np.inf
    f.correct(Scan(0.0, BEARINGS, ranges))
    check_sound(f)
    assert near(f.hypotheses[0].pose, drive.true, 0.02, 0.05)


@each_filter
@pytest.mark.parametrize(
    ("told", "sds"),
    [(Pose2(50, -70, 1), (0.5, 0.5, 1.0)), (Pose2(), (100.0, 100.0, 3.0))],
    ids=["far outside the field", "a hundred metres wide"],
)
def test_what_is_absurd_is_no_burden(
    make: Make, told: Pose2, sds: tuple[float, float, float]
) -> None:
    f, drive = make(0), Drive()
    f.set_pose(told, np.diag(np.square(sds)))
    for moved, scan in drive.eight(0.2):
        f.predict(moved)
        f.correct(scan)
        check_sound(f)


@each_filter
@settings(max_examples=15)
@given(
    told=st.tuples(*[st.floats(-0.6, 0.6)] * 2, st.floats(-3.14, 3.14)),
    sds=st.tuples(*[st.sampled_from([0.0, 0.001, 0.02, 0.3])] * 2),
    step=st.tuples(*[st.floats(-0.3, 0.3)] * 2, st.floats(-3.14, 3.14)),
)
def test_whatever_it_is_told_and_driven_it_stays_sound(
    make: Make,
    told: tuple[float, float, float],
    sds: tuple[float, float],
    step: tuple[float, float, float],
) -> None:
    f = make(0)
    f.set_pose(Pose2(*told), np.diag(np.square([sds[0], sds[0], sds[1]])))
    scan = Drive().scan()
    for _ in range(2):
        f.predict(Pose2(*step))
        f.correct(scan)
        check_sound(f)


# --- it is the same again


@each_filter
def test_the_same_seed_gives_the_same_estimates_bit_for_bit(make: Make) -> None:
    def run() -> list[tuple[float, ...]]:
        f, drive = make(3), Drive()
        f.scatter()
        f.correct(drive.scan())
        f.set_pose(Pose2(0.02, 0.01, 0.05), START)
        found: list[tuple[float, ...]] = []
        for moved, scan in drive.eight(0.3):
            f.predict(moved)
            f.correct(scan)
            pose = f.hypotheses[0].pose
            found.append((pose.x, pose.y, pose.theta, f.effective))
        return found

    assert run() == run()


@each_filter
def test_to_look_at_it_after_a_scan_does_not_change_it(make: Make) -> None:
    looked_at, left_alone = make(0), make(0)
    for f in (looked_at, left_alone):
        f.set_pose(Pose2(0.02, 0.01, 0.05), NARROW)
    for moved, scan in Drive().eight(0.3):
        for f in (looked_at, left_alone):
            f.predict(moved)
            f.correct(scan)
        looked_at.hypotheses, looked_at.cloud, looked_at.effective  # noqa: B018
    assert looked_at.hypotheses[0].pose == left_alone.hypotheses[0].pose
    np.testing.assert_array_equal(looked_at.cloud.poses, left_alone.cloud.poses)
