"""The filter follows a robot by its scans, and knows what it does not know."""

from __future__ import annotations

import math

import numpy as np
import pytest
from particle_robot import WALL, WALL_SENSOR, Tracker, sensor_named, still, track, tracker_of
from square_drive import ON_SQUARE, SQUARE
from stub_drive import BEARINGS, DEFAULTS, PERIOD, STUB, Drive

from robot.geometry import Array, Pose2, Twist2
from robot.localization.filter import Cloud
from robot.localization.models.sensor_models import SENSOR_MODELS
from robot.localization.parameters import FilterParameters
from robot.scan import Scan

# --- it follows the robot


@pytest.mark.parametrize("name", SENSOR_MODELS)
def test_it_stays_on_the_robot_for_a_lap(name: str) -> None:
    f, drive = tracker_of(sensor_named(name)), Drive()
    f.told(drive.true, 0.02, 0.05)
    found = track(f, drive, 8.0)
    errors = np.array([(d, a) for _, d, a in found[30:]])
    assert errors[:, 0].mean() < 0.002 and errors[:, 0].max() < 0.01
    assert errors[:, 1].mean() < 0.01
    dead_reckoning = (Pose2() @ drive.odometry).distance_to(drive.true)
    assert dead_reckoning > 0.01, "odometry alone would be off"


@pytest.mark.parametrize("seed", range(3))
def test_told_a_wrong_pose_it_finds_the_right_one(seed: int) -> None:
    f, drive = tracker_of(seed=seed), Drive()
    f.set_pose(Pose2(-0.1, -0.1, 0.3))
    found = track(f, drive, 4.0)
    assert all(d < 0.02 and a < 0.1 for _, d, a in found[-30:])


def test_its_covariance_is_about_as_wide_as_its_error() -> None:
    """Neither a tenth of it nor ten times it, over a lap; told a little wrong."""
    f, drive = tracker_of(), Drive()
    f.told(Pose2(0.02, 0.01, 0.05), 0.03, 0.1)
    found = track(f, drive, 6.0)[30:]
    claimed = np.sqrt(np.mean([e.covariance[0, 0] + e.covariance[1, 1] for e, _, _ in found]))
    made = np.sqrt(np.mean([d**2 for _, d, _ in found]))
    assert 0.3 < claimed / made < 10


def test_an_estimate_is_the_heaviest_cluster_and_has_its_stamp() -> None:
    f, drive = tracker_of(), Drive()
    f.told(drive.true, 0.05, 0.1)
    for estimate, _, _ in track(f, drive, 0.5):
        weights = [h.weight for h in estimate.hypotheses]
        assert weights == sorted(weights, reverse=True)
        assert 0 < weights[0] <= 1 + 1e-9 and sum(weights) <= 1 + 1e-9
        assert estimate.pose == estimate.hypotheses[0].pose
        assert estimate.covariance.shape == (3, 3)
        assert 1 <= estimate.effective <= DEFAULTS.filter.max_particles
    assert estimate.stamp == drive.stamp


def test_two_places_that_look_alike_are_two_hypotheses() -> None:
    """Particles at the robot and at its mirror image; the map is the same in both."""
    f = tracker_of(ON_SQUARE.sensor)
    true = Pose2(0.1, 0.2, 0.4)
    rng = np.random.default_rng(0)
    here = true.to_array() + rng.normal(0, [0.01, 0.01, 0.02], (1000, 3))
    turned = Pose2(0, 0, math.pi / 2) @ true
    there = turned.to_array() + rng.normal(0, [0.01, 0.01, 0.02], (1000, 3))
    f.set_cloud(Cloud.even(np.vstack([here, there])))
    drive = Drive(true, edges_of=SQUARE)
    estimate = f.update(drive.odometry, drive.step(Twist2())[1])
    assert estimate is not None and len(estimate.hypotheses) >= 2
    one, other = estimate.hypotheses[:2]
    assert one.weight + other.weight > 0.95 and other.weight > 0.2
    assert {round(one.pose.theta, 1), round(other.pose.theta, 1)} == {0.4, 2.0}


# --- what it is told


def test_a_told_pose_is_spread_as_told() -> None:
    f = tracker_of()
    f.told(Pose2(0.1, 0.2, math.pi), 0.05, 0.2)
    poses = f.cloud.poses
    assert len(poses) == DEFAULTS.filter.max_particles
    assert ((poses[:, 2] >= -math.pi) & (poses[:, 2] < math.pi)).all()
    turned = (poses[:, 2] + 2 * math.pi) % (2 * math.pi) - math.pi
    np.testing.assert_allclose(poses[:, :2].mean(axis=0), [0.1, 0.2], atol=4e-3)
    np.testing.assert_allclose(poses[:, :2].std(axis=0), 0.05, rtol=0.05)
    assert turned.std() == pytest.approx(0.2, rel=0.05)
    np.testing.assert_allclose(f.cloud.weights, 1 / len(poses))
    told = f.estimate(3.0)
    assert told.stamp == 3.0
    assert told.pose.distance_to(Pose2(0.1, 0.2)) < 0.01
    assert told.effective == pytest.approx(len(poses))


def test_without_a_spread_the_one_set_is_taken() -> None:
    f = tracker_of(initial_sd_xy=0.07, initial_sd_theta=0.11)
    f.set_pose(Pose2())
    np.testing.assert_allclose(f.cloud.poses.std(axis=0), [0.07, 0.07, 0.11], rtol=0.05)


def test_given_particles_are_taken_as_they_are() -> None:
    f = tracker_of()
    poses = STUB.free_poses(np.random.default_rng(0), 700)
    f.set_cloud(Cloud.even(poses))
    np.testing.assert_array_equal(f.cloud.poses, poses)
    assert f.updates == 0


# --- what it must not do


def test_the_same_seed_gives_the_same_estimates_bit_for_bit() -> None:
    def run(seed: int) -> list[tuple[float, float, float]]:
        f, drive = tracker_of(seed=seed), Drive()
        f.set_pose(Pose2(-0.05, 0.05, 0.1))
        return [(e.pose.x, e.pose.theta, e.effective) for e, _, _ in track(f, drive, 0.7)]

    assert run(3) == run(3)
    assert run(3) != run(4)


@pytest.mark.parametrize("name", ["likelihood_field", "likelihood_field_prob"])
def test_without_a_return_it_follows_odometry_and_stays_finite(name: str) -> None:
    f, drive = tracker_of(sensor_named(name)), Drive()
    f.told(drive.true, 0.02, 0.05)
    for _ in drive.eight(2.0):
        blind = Scan(drive.stamp, BEARINGS, np.full(61, np.inf))
        estimate = f.update(drive.odometry, blind)
        assert estimate is not None
        assert estimate.pose.is_finite() and np.isfinite(estimate.covariance).all()
        assert np.isfinite(f.cloud.poses).all() and np.isfinite(f.cloud.weights).all()
    assert estimate.pose.distance_to(drive.odometry) < 0.03
    np.testing.assert_allclose(f.filter.cloud.weights, 1 / len(f.filter.cloud.weights))


NOTHING = Scan(0.0, BEARINGS, np.full(61, np.inf))


@pytest.mark.parametrize("name", ["beam", "likelihood_field"])
def test_to_the_beam_model_it_says_much_that_nothing_returned(name: str) -> None:
    """Told to be amid the field, or off it with nothing ahead."""
    f = tracker_of(sensor_named(name))
    f.set_cloud(Cloud.even(np.repeat([[0.0, 0, 0], [2.0, 0, 0]], 500, axis=0)))
    for odometry in (Pose2(), Pose2(0.01)):
        estimate = f.update(odometry, NOTHING)
        assert estimate is not None and np.isfinite(f.cloud.weights).all()
    amid = f.filter.cloud.weights[f.filter.cloud.poses[:, 0] < 1].sum()
    assert amid < 0.1 if name == "beam" else amid == pytest.approx(0.5, abs=0.02)


def test_to_no_model_a_scan_of_no_rays_says_anything() -> None:
    f = tracker_of(sensor_named("beam"))
    f.told(Pose2(), 0.02, 0.05)
    f.update(Pose2(), Scan(0.0, BEARINGS[:0], np.empty(0)))
    assert np.ptp(f.filter.cloud.weights) == 0


def test_weights_always_sum_to_one_also_far_off_the_field() -> None:
    f, drive = tracker_of(), Drive()
    f.told(Pose2(50, 50, 1), 0.5, 1.0)
    for _, scan in drive.eight(0.5):
        f.update(drive.odometry, scan)
        for cloud in (f.cloud, f.filter.cloud):
            assert cloud.weights.sum() == pytest.approx(1)
            assert len(cloud.weights) == len(cloud.poses)
            assert np.isfinite(cloud.poses).all()


def test_one_sharp_scan_does_not_leave_one_particle() -> None:
    """A wide cloud under a likelihood much narrower than the gaps between its particles."""
    f = tracker_of(min_effective=0.05)
    f.told(Pose2(0.05, 0.05, 0.1), 0.3, 1.0)
    estimate = still(f)
    assert estimate is not None
    assert estimate.effective >= 0.05 * DEFAULTS.filter.max_particles - 1e-6


def test_a_cloud_spread_a_hundred_metres_wide_is_no_burden() -> None:
    f = tracker_of()
    f.told(Pose2(), 100.0, 3.0)
    estimate = still(f)
    assert estimate is not None and estimate.pose.is_finite()


# --- what it cannot know


def along_a_wall(seconds: float, seed: int) -> Tracker:
    """Turned to and fro before a single wall along x, which says nothing of x."""
    f = tracker_of(WALL_SENSOR, seed)
    drive = Drive(Pose2(0, 0, math.pi / 2), edges_of=WALL)
    f.told(drive.true, 0.02, 0.05)
    for tick in range(round(seconds / PERIOD)):
        f.update(drive.odometry, drive.step(Twist2(0, 0.6 * math.cos(2 * tick * PERIOD)))[1])
    return f


def spread(cloud: Cloud) -> Array:
    mean = np.average(cloud.poses, axis=0, weights=cloud.weights)
    return np.sqrt(np.average((cloud.poses - mean) ** 2, axis=0, weights=cloud.weights))


def test_along_a_single_wall_it_neither_learns_nor_forgets() -> None:
    """Told to 20 mm along the wall, which no scan can better: by chance it wanders, to both sides.

    Across the wall, and in heading, it is sharp the while.
    """
    widths = np.array([spread(along_a_wall(4.0, seed).cloud) for seed in range(6)])
    along, across, heading = widths.T
    assert (along > 0.005).all() and (along < 0.06).all()
    assert 0.010 < np.sqrt(np.mean(along**2)) < 0.035
    assert (across < 0.002).all() and (heading < 0.03).all()


# --- lost, and given poses


def test_kidnapped_it_tries_elsewhere_only_when_asked_to() -> None:
    def spread_after(**alphas: float) -> float:
        f, drive = tracker_of(min_particles=800, **alphas), Drive(Pose2(0.1, 0, 0.5))
        f.told(drive.true, 0.01, 0.02)
        track(f, drive, 1.0)
        drive.true = Pose2(-0.25, 0.2, -2.0)
        widest = 0.0
        for _, scan in drive.eight(0.5):
            f.update(drive.odometry, scan)
            widest = max(widest, float(np.ptp(f.cloud.poses[:, 0])))
        return widest

    assert spread_after() < 0.3
    assert spread_after(recovery_alpha_slow=0.01, recovery_alpha_fast=0.3) > 0.7


class _Flat:
    """Any scan fits anywhere."""

    def log_likelihood(self, poses: Array, _: Scan) -> Array:
        return np.zeros(len(poses))


def test_weights_of_given_particles_count() -> None:
    """Two places that look alike, told as nine to one, stay about nine to one."""
    f = tracker_of(_Flat())
    here, there = np.tile([0.0, 0, 0], (500, 1)), np.tile([0.4, 0.2, 1.0], (500, 1))
    weights = np.repeat([0.9 / 500, 0.1 / 500], 500)
    f.set_cloud(Cloud(np.vstack([here, there]), weights))
    assert [h.weight for h in f.filter.hypotheses] == pytest.approx([0.9, 0.1])
    estimate = still(f)
    assert estimate is not None
    assert [h.weight for h in estimate.hypotheses] == pytest.approx([0.9, 0.1])
    assert np.mean(f.cloud.poses[:, 0] < 0.2) == pytest.approx(0.9, abs=0.01)


def test_parameters_can_change_while_it_runs() -> None:
    f, drive = tracker_of(), Drive()
    f.told(drive.true, 0.02, 0.05)
    track(f, drive, 0.5)
    f.filter.parameters = FilterParameters(min_particles=900, max_particles=1000, cell_xy=0.01)
    f.filter.sensor = sensor_named("beam")
    found = track(f, drive, 1.0)
    assert 900 <= len(f.cloud.poses) <= 1000
    assert found[-1][1] < 0.01
