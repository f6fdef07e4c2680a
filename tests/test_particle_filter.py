"""The filter follows a robot by its scans, and knows what it does not know."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
import pytest
import shapely

from robot.fields.edge_index import index_edges
from robot.fields.edges import outline
from robot.fields.field_loading import load_field
from robot.fields.ray_casting import cast_rays
from robot.geometry import Array, Pose2, Twist2
from robot.localization.estimate import Estimate
from robot.localization.filter import Cloud
from robot.localization.localizer import Localizer
from robot.localization.models.entry_field import EntryField
from robot.localization.models.motion_models import DifferentialMotion
from robot.localization.models.sensor_models import SensorModel, sensor_model
from robot.localization.parameters import SENSOR_MODELS, FilterParameters, LocalizationParameters
from robot.localization.particles.particle_filter import ParticleFilter
from robot.scan import Scan

STUB = load_field("stub", Path(__file__).parent.parent / "maps")
WALL = replace(STUB, edges=outline(shapely.box(-9, 0.475, 9, 0.525)))
"""One straight piece of tape: it says nothing of where along it the robot is."""

DEFAULTS = LocalizationParameters()
BEARINGS = np.radians(np.linspace(-31, 31, 61))
PERIOD = 1 / 30
ENTRIES = {id(of): EntryField.build(of, resolution=0.005, max_distance=0.15) for of in (STUB, WALL)}


def sensor_of(edges_of: object = STUB, name: str = "likelihood_field") -> SensorModel:
    parameters = replace(DEFAULTS.sensor, laser_model_type=name)
    return sensor_model(parameters, ENTRIES[id(edges_of)], edges_of.edges)  # type: ignore[attr-defined]


class Tracker(Localizer):
    """A particle filter fed by odometry and scans, with its particles at hand."""

    filter: ParticleFilter

    @property
    def cloud(self) -> Cloud:
        """After resampling."""
        return self.filter._particles

    def told(self, pose: Pose2, sd_xy: float, sd_theta: float) -> None:
        self.set_pose(pose, np.diag(np.square([sd_xy, sd_xy, sd_theta])))


def filter_of(
    edges_of: object = STUB, seed: int = 0, name: str = "likelihood_field", **changes: float
) -> Tracker:
    parameters = replace(DEFAULTS.filter, **changes)
    made = ParticleFilter(
        DEFAULTS.motion.model(),
        sensor_of(edges_of, name),
        STUB,
        parameters,
        np.random.default_rng(seed),
        likelihood_weight=DEFAULTS.sensor.likelihood_weight,
    )
    return Tracker(made, parameters)


def scan_at(pose: Pose2, stamp: float, edges: Array, rng: np.random.Generator) -> Scan:
    ranges = np.empty((1, len(BEARINGS)))
    cast_rays(pose.to_array()[None], BEARINGS, index_edges(edges), 1.0, ranges)
    return Scan(stamp, BEARINGS, ranges[0] + 0.0003 * rng.standard_normal(len(BEARINGS)))


@dataclass
class Drive:
    """A robot whose odometry errs, and its scans."""

    true: Pose2
    odometry: Pose2 = Pose2()
    edges: Array = field(default_factory=lambda: STUB.edges)
    stamp: float = 0.0
    rng: np.random.Generator = field(default_factory=lambda: np.random.default_rng(7))

    def step(self, twist: Twist2) -> Scan:
        """One period; odometry overestimates the way by 1 % and the turn by 2 %."""
        self.stamp += PERIOD
        self.true = self.true @ twist.integrate(PERIOD)
        seen = Twist2(1.01 * twist.v, 1.02 * twist.omega)
        self.odometry = self.odometry @ seen.integrate(PERIOD)
        return scan_at(self.true, self.stamp, self.edges, self.rng)


def eight(seconds: float) -> Iterator[Twist2]:
    """Two circles of 190 mm, one after the other."""
    for tick in range(round(seconds / PERIOD)):
        yield Twist2(0.15, 0.79 if (tick * PERIOD) % 15.9 < 7.95 else -0.79)


def follow(f: Tracker, drive: Drive, seconds: float) -> list[tuple[Estimate, float, float]]:
    """Estimates along the figure-eight, and how far they are off [m] and [rad]."""
    found = []
    for twist in eight(seconds):
        scan = drive.step(twist)
        estimate = f.update(drive.odometry, scan)
        if estimate is not None:
            pose = estimate.pose
            found.append((estimate, pose.distance_to(drive.true), abs(pose.turn_to(drive.true))))
    return found


# --- it follows the robot


@pytest.mark.parametrize("name", SENSOR_MODELS)
def test_it_stays_on_the_robot_for_a_lap(name: str) -> None:
    f, drive = filter_of(name=name), Drive(Pose2())
    f.told(drive.true, 0.02, 0.05)
    found = follow(f, drive, 8.0)
    errors = np.array([(d, a) for _, d, a in found[30:]])
    assert errors[:, 0].mean() < 0.002 and errors[:, 0].max() < 0.01
    assert errors[:, 1].mean() < 0.01
    dead_reckoning = (Pose2() @ drive.odometry).distance_to(drive.true)
    assert dead_reckoning > 0.01, "odometry alone would be off"


@pytest.mark.parametrize("seed", range(3))
def test_told_a_wrong_pose_it_finds_the_right_one(seed: int) -> None:
    f, drive = filter_of(seed=seed), Drive(Pose2())
    f.set_pose(Pose2(-0.1, -0.1, 0.3))
    found = follow(f, drive, 4.0)
    assert all(d < 0.02 and a < 0.1 for _, d, a in found[-30:])


def test_its_covariance_is_about_as_wide_as_its_error() -> None:
    """Neither a tenth of it nor ten times it, over a lap; told a little wrong."""
    f, drive = filter_of(), Drive(Pose2())
    f.told(Pose2(0.02, 0.01, 0.05), 0.03, 0.1)
    found = follow(f, drive, 6.0)[30:]
    claimed = np.sqrt(np.mean([e.covariance[0, 0] + e.covariance[1, 1] for e, _, _ in found]))
    made = np.sqrt(np.mean([d**2 for _, d, _ in found]))
    assert 0.3 < claimed / made < 10


def test_an_estimate_is_the_heaviest_cluster_and_has_its_stamp() -> None:
    f, drive = filter_of(), Drive(Pose2())
    f.told(drive.true, 0.05, 0.1)
    for estimate, _, _ in follow(f, drive, 0.5):
        weights = [h.weight for h in estimate.hypotheses]
        assert weights == sorted(weights, reverse=True)
        assert 0 < weights[0] <= 1 + 1e-9 and sum(weights) <= 1 + 1e-9
        assert estimate.pose == estimate.hypotheses[0].pose
        assert estimate.covariance.shape == (3, 3)
        assert 1 <= estimate.effective <= DEFAULTS.filter.max_particles
    assert estimate.stamp == drive.stamp


def test_two_places_that_look_alike_are_two_hypotheses() -> None:
    """Particles at the robot and at its mirror image; the map is the same in both."""
    f = filter_of()
    square = replace(STUB, edges=load_field("square", Path(__file__).parent.parent / "maps").edges)
    f.filter.sensor = sensor_model(
        DEFAULTS.sensor, EntryField.build(square, resolution=0.005, max_distance=0.15), square.edges
    )
    true = Pose2(0.1, 0.2, 0.4)
    rng = np.random.default_rng(0)
    here = true.to_array() + rng.normal(0, [0.01, 0.01, 0.02], (1000, 3))
    turned = Pose2(0, 0, math.pi / 2) @ true
    there = turned.to_array() + rng.normal(0, [0.01, 0.01, 0.02], (1000, 3))
    f.set_cloud(Cloud.even(np.vstack([here, there])))
    drive = Drive(true, edges=square.edges)
    estimate = f.update(drive.odometry, drive.step(Twist2()))
    assert estimate is not None and len(estimate.hypotheses) >= 2
    one, other = estimate.hypotheses[:2]
    assert one.weight + other.weight > 0.95 and other.weight > 0.2
    assert {round(one.pose.theta, 1), round(other.pose.theta, 1)} == {0.4, 2.0}


# --- what it is told


def test_a_told_pose_is_spread_as_told() -> None:
    f = filter_of()
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
    f = filter_of(initial_sd_xy=0.07, initial_sd_theta=0.11)
    f.set_pose(Pose2())
    np.testing.assert_allclose(f.cloud.poses.std(axis=0), [0.07, 0.07, 0.11], rtol=0.05)


def test_given_particles_are_taken_as_they_are() -> None:
    f = filter_of()
    poses = STUB.free_poses(np.random.default_rng(0), 700)
    f.set_cloud(Cloud.even(poses))
    np.testing.assert_array_equal(f.cloud.poses, poses)
    assert f.updates == 0


def test_what_was_driven_before_a_pose_is_told_is_not_driven_again() -> None:
    f, drive = filter_of(update_min_d=5.0, update_min_a=6.0), Drive(Pose2())
    f.told(drive.true, 0.01, 0.01)
    f.update(drive.odometry, drive.step(Twist2()))
    for twist in eight(3.0):
        drive.step(twist)
    f.update(drive.odometry, drive.step(Twist2()))
    f.told(drive.true, 0.01, 0.01)
    estimate = f.update(drive.odometry, drive.step(Twist2()))
    assert estimate is not None
    assert estimate.pose.distance_to(drive.true) < 0.01


# --- when a measurement counts


def still(f: Tracker, odometry: Pose2 = Pose2()) -> Estimate | None:
    """A scan from the origin, with odometry that says something or nothing."""
    return f.update(odometry, scan_at(Pose2(), 0.0, STUB.edges, np.random.default_rng(0)))


@pytest.fixture
def standing() -> Tracker:
    """It has taken its first scan."""
    f = filter_of()
    f.told(Pose2(), 0.02, 0.05)
    assert still(f) is not None
    return f


def test_the_first_scan_counts_and_then_none_while_it_stands(standing: Tracker) -> None:
    before = standing.cloud
    for _ in range(5):
        assert still(standing) is None
    assert standing.cloud is before
    assert standing.updates == 1


@pytest.mark.parametrize(
    ("moved", "counts"),
    [
        (Pose2(0.0019), False),
        (Pose2(0.0021), True),
        (Pose2(0, -0.0021), True),
        (Pose2(0, 0, 0.0049), False),
        (Pose2(0, 0, 0.0051), True),
        (Pose2(0, 0, -0.0051), True),
    ],
)
def test_enough_travel_or_turn_makes_a_scan_count(
    standing: Tracker, moved: Pose2, counts: bool
) -> None:
    assert (still(standing, moved) is not None) == counts


def test_small_steps_add_up_until_they_count_and_none_is_lost() -> None:
    f = filter_of(update_min_d=0.01)
    f.filter.motion = DifferentialMotion(0, 0, 0, 0)
    f.set_cloud(Cloud.even(np.zeros((50, 3))))
    f.predict(Pose2())
    counted = [f.predict(Pose2(0.003 * tick)) for tick in range(1, 12)]
    assert [tick for tick, c in enumerate(counted, start=1) if c] == [4, 8]
    np.testing.assert_allclose(f.cloud.poses[:, 0], 0.024)


def test_a_forced_update_counts_once_though_it_stands(standing: Tracker) -> None:
    standing.force_update()
    assert still(standing) is not None
    assert still(standing) is None


def test_a_told_pose_makes_the_next_scan_count(standing: Tracker) -> None:
    standing.told(Pose2(), 0.02, 0.05)
    assert still(standing) is not None


# --- while measurements are paused


def test_paused_the_cloud_follows_odometry_and_spreads() -> None:
    f, drive = filter_of(), Drive(Pose2(0.1, 0, 0.5))
    f.told(drive.true, 0.005, 0.01)
    f.predict(drive.odometry)
    narrow = f.estimate(0.0).covariance.trace()
    for twist in eight(2.0):
        drive.step(twist)
        f.predict(drive.odometry)
    estimate = f.estimate(2.0)
    there = Pose2(0.1, 0, 0.5) @ drive.odometry
    assert estimate.pose.distance_to(there) < 0.01
    assert estimate.covariance.trace() > 2 * narrow
    assert f.updates == 0
    assert f.filter.cloud is f.cloud


# --- how many particles there are


def test_with_certainty_the_number_of_particles_falls() -> None:
    f, drive = filter_of(), Drive(Pose2())
    f.set_pose(drive.true)
    assert len(f.cloud.poses) == DEFAULTS.filter.max_particles
    follow(f, drive, 2.0)
    assert len(f.cloud.poses) == DEFAULTS.filter.min_particles


def test_scattered_over_the_field_it_keeps_as_many_as_it_may() -> None:
    f = filter_of(max_particles=3000)
    f.set_cloud(Cloud.even(STUB.free_poses(np.random.default_rng(0), 3000)))
    still(f)
    assert len(f.cloud.poses) > 2000


def test_limits_of_the_number_hold_whatever_the_formula_wants() -> None:
    for least, most in ((700, 900), (2000, 2000), (800, 100)):
        f, drive = filter_of(min_particles=least, max_particles=most), Drive(Pose2())
        f.set_pose(drive.true)
        for _ in follow(f, drive, 0.5):
            assert least <= len(f.cloud.poses) <= max(least, most)


def test_it_resamples_as_often_as_asked() -> None:
    f, drive = filter_of(resample_interval=5), Drive(Pose2())
    f.told(drive.true, 0.02, 0.05)
    even = []
    for twist in eight(0.4):
        f.update(drive.odometry, drive.step(twist))
        even.append(np.ptp(f.cloud.weights) == 0)
    assert even == [(i + 1) % 5 == 0 for i in range(len(even))]


def test_selective_it_resamples_only_when_few_particles_count() -> None:
    f, drive = filter_of(selective_resampling=True), Drive(Pose2())
    f.told(drive.true, 0.02, 0.05)
    kept = 0
    for twist in eight(2.0):
        f.update(drive.odometry, drive.step(twist))
        few = (1 / np.square(f.filter.cloud.weights).sum()) < 0.5 * len(f.filter.cloud.weights)
        assert few == (np.ptp(f.cloud.weights) == 0)
        kept += not few
    assert kept > 10


# --- what it must not do


def test_the_same_seed_gives_the_same_estimates_bit_for_bit() -> None:
    def run(seed: int) -> list[tuple[float, float, float]]:
        f, drive = filter_of(seed=seed), Drive(Pose2())
        f.set_pose(Pose2(-0.05, 0.05, 0.1))
        return [(e.pose.x, e.pose.theta, e.effective) for e, _, _ in follow(f, drive, 0.7)]

    assert run(3) == run(3)
    assert run(3) != run(4)


@pytest.mark.parametrize("name", SENSOR_MODELS)
def test_without_a_return_it_follows_odometry_and_stays_finite(name: str) -> None:
    f, drive = filter_of(name=name), Drive(Pose2())
    f.told(drive.true, 0.02, 0.05)
    for twist in eight(2.0):
        drive.step(twist)
        blind = Scan(drive.stamp, BEARINGS, np.full(61, np.inf))
        estimate = f.update(drive.odometry, blind)
        assert estimate is not None
        assert estimate.pose.is_finite() and np.isfinite(estimate.covariance).all()
        assert np.isfinite(f.cloud.poses).all() and np.isfinite(f.cloud.weights).all()
    assert estimate.pose.distance_to(drive.odometry) < 0.03
    np.testing.assert_allclose(f.filter.cloud.weights, 1 / len(f.filter.cloud.weights))


def test_weights_always_sum_to_one_also_far_off_the_field() -> None:
    f, drive = filter_of(), Drive(Pose2())
    f.told(Pose2(50, 50, 1), 0.5, 1.0)
    for twist in eight(0.5):
        f.update(drive.odometry, drive.step(twist))
        for cloud in (f.cloud, f.filter.cloud):
            assert cloud.weights.sum() == pytest.approx(1)
            assert len(cloud.weights) == len(cloud.poses)
            assert np.isfinite(cloud.poses).all()


def test_one_sharp_scan_does_not_leave_one_particle() -> None:
    """A wide cloud under a likelihood much narrower than the gaps between its particles."""
    f = filter_of(min_effective=0.05)
    f.told(Pose2(0.05, 0.05, 0.1), 0.3, 1.0)
    estimate = still(f)
    assert estimate is not None
    assert estimate.effective >= 0.05 * DEFAULTS.filter.max_particles - 1e-6


def test_a_cloud_spread_a_hundred_metres_wide_is_no_burden() -> None:
    f = filter_of()
    f.told(Pose2(), 100.0, 3.0)
    estimate = still(f)
    assert estimate is not None and estimate.pose.is_finite()


# --- what it cannot know


def along_a_wall(seconds: float, seed: int, **changes: float) -> Tracker:
    """Turned to and fro before a single wall along x, which says nothing of x."""
    f, drive = filter_of(WALL, seed, **changes), Drive(Pose2(0, 0, math.pi / 2), edges=WALL.edges)
    f.told(drive.true, 0.02, 0.05)
    for tick in range(round(seconds / PERIOD)):
        f.update(drive.odometry, drive.step(Twist2(0, 0.6 * math.cos(2 * tick * PERIOD))))
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
        f, drive = filter_of(min_particles=800, **alphas), Drive(Pose2(0.1, 0, 0.5))
        f.told(drive.true, 0.01, 0.02)
        follow(f, drive, 1.0)
        drive.true = Pose2(-0.25, 0.2, -2.0)
        widest = 0.0
        for twist in eight(0.5):
            f.update(drive.odometry, drive.step(twist))
            widest = max(widest, float(np.ptp(f.cloud.poses[:, 0])))
        return widest

    assert spread_after() < 0.3
    assert spread_after(recovery_alpha_slow=0.01, recovery_alpha_fast=0.3) > 0.7


def test_weights_of_given_particles_count() -> None:
    """Two places that look alike, told as nine to one, stay about nine to one."""
    f = filter_of()
    f.filter.sensor = FLAT
    here, there = np.tile([0.0, 0, 0], (500, 1)), np.tile([0.4, 0.2, 1.0], (500, 1))
    weights = np.repeat([0.9 / 500, 0.1 / 500], 500)
    f.set_cloud(Cloud(np.vstack([here, there]), weights))
    assert [h.weight for h in f.filter.hypotheses] == pytest.approx([0.9, 0.1])
    estimate = still(f)
    assert estimate is not None
    assert [h.weight for h in estimate.hypotheses] == pytest.approx([0.9, 0.1])
    assert np.mean(f.cloud.poses[:, 0] < 0.2) == pytest.approx(0.9, abs=0.01)


class _Flat:
    """Any scan fits anywhere."""

    def log_likelihood(self, poses: Array, _: Scan) -> Array:
        return np.zeros(len(poses))


FLAT = _Flat()


def test_parameters_can_change_while_it_runs() -> None:
    f, drive = filter_of(), Drive(Pose2())
    f.told(drive.true, 0.02, 0.05)
    follow(f, drive, 0.5)
    f.filter.parameters = FilterParameters(min_particles=900, max_particles=1000, cell_xy=0.01)
    f.filter.sensor = sensor_of(name="beam")
    found = follow(f, drive, 1.0)
    assert 900 <= len(f.cloud.poses) <= 1000
    assert found[-1][1] < 0.01
