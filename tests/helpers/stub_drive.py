"""A robot on the field "stub", its erring odometry and its scans, and filters that follow it."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np
import pytest
from places import MAPS

from robot.fields.field import Field
from robot.fields.field_loading import load_field
from robot.fields.ray_casting import cast_rays, cast_toward
from robot.geometry import Array, Pose2, Twist2, compose
from robot.localization.filter import Filter
from robot.localization.models.entry_field import EntryField
from robot.localization.models.sensor_models import sensor_model
from robot.localization.parameters import LocalizationParameters
from robot.localization.scan_matching import ScanMatcher
from robot.scan import Scan

STUB = load_field("stub", MAPS)
DEFAULTS = LocalizationParameters()
ENTRIES = EntryField.build(STUB, resolution=0.005, max_distance=0.15)
SENSOR = sensor_model(DEFAULTS.sensor, ENTRIES, STUB.edges)
BEARINGS = np.radians(np.linspace(-31, 31, 61))
NOISE_M = 0.0003
PERIOD = 1 / 30


def matcher_of(edges_of: Field = STUB, sd: float = 0.02) -> ScanMatcher:
    return ScanMatcher(edges_of.edge_index, 1.0, sd, gate=0.06)


@dataclass
class Drive:
    """A robot, its odometry that says 1 % more of the way and 2 % more of a turn, and its scans."""

    true: Pose2 = Pose2()
    odometry: Pose2 = Pose2()
    robot_from_scan: Pose2 = Pose2()
    edges_of: Field = STUB
    stamp: float = 0.0
    rng: np.random.Generator = field(default_factory=lambda: np.random.default_rng(7))

    def step(self, twist: Twist2) -> tuple[Pose2, Scan]:
        """One period: the step by odometry, and the scan at its end."""
        self.stamp += PERIOD
        self.true = self.true @ twist.integrate(PERIOD)
        moved = Twist2(1.01 * twist.v, 1.02 * twist.omega).integrate(PERIOD)
        self.odometry = self.odometry @ moved
        return moved, self.scan()

    def scan(self) -> Scan:
        centre = self.true @ self.robot_from_scan
        ranges = np.empty((1, len(BEARINGS)))
        cast_rays(centre.to_array()[None], BEARINGS, self.edges_of.edge_index, 1.0, ranges)
        noise = NOISE_M * self.rng.standard_normal(len(BEARINGS))
        return Scan(self.stamp, BEARINGS, ranges[0] + noise, self.robot_from_scan)

    def eight(self, seconds: float) -> Iterator[tuple[Pose2, Scan]]:
        """Steps and scans along two circles of 190 mm, one after the other."""
        for tick in range(round(seconds / PERIOD)):
            yield self.step(Twist2(0.15, 0.79 if (tick * PERIOD) % 15.9 < 7.95 else -0.79))


def draw_poses(
    rng: np.random.Generator, mean: Pose2, sds: tuple[float, float, float], count: int
) -> Array:
    """Poses (count, 3) about a mean."""
    offsets = rng.normal(0, sds, (count, 3))
    return compose(np.add(offsets, (mean.x, mean.y, mean.theta)), np.zeros(3))


def near(found: Pose2, wanted: Pose2, metres: float, radians: float) -> bool:
    return found.distance_to(wanted) <= metres and abs(found.turn_to(wanted)) <= radians


def follow(f: Filter, drive: Drive, seconds: float) -> list[float]:
    """How far the estimate is off after each scan of a drive [m]."""
    errors = []
    for moved, scan in drive.eight(seconds):
        f.predict(moved)
        f.correct(scan)
        errors.append(f.hypotheses[0].pose.distance_to(drive.true))
    return errors


def noisy_scan(true: Pose2, sd: float, rng: np.random.Generator) -> Scan:
    """Each end errs by itself, across the edge: as the filter supposes."""
    ranges = np.empty(len(BEARINGS))
    for i, bearing in enumerate(BEARINGS):
        dx, dy = math.cos(true.theta + bearing), math.sin(true.theta + bearing)
        distance, edge = cast_toward(true.x, true.y, dx, dy, STUB.edge_index, 1.0)
        if edge < 0:
            ranges[i] = np.inf
            continue
        ex, ey = STUB.edge_index.edges[edge, 2:] - STUB.edge_index.edges[edge, :2]
        sine = abs(dx * ey - dy * ex) / math.hypot(ex, ey)
        ranges[i] = distance + sd / sine * rng.standard_normal()
    return Scan(0.0, BEARINGS, ranges)


def check_sound(f: Filter) -> None:
    cloud, found = f.cloud, f.hypotheses
    assert cloud.poses.shape == (len(cloud.weights), 3) and 1 <= len(cloud.weights) <= 20_000
    assert np.isfinite(cloud.poses).all()
    assert (np.abs(cloud.poses[:, 2]) <= math.pi).all()
    assert (cloud.weights >= 0).all() and cloud.weights.sum() == pytest.approx(1)
    assert 1 - 1e-9 <= f.effective < math.inf
    weights = [one.weight for one in found]
    assert weights == sorted(weights, reverse=True)
    assert all(0 < w <= 1 + 1e-9 for w in weights) and sum(weights) <= 1 + 1e-9
    for one in found:
        assert one.pose.is_finite()
        check_covariance(one.covariance)


def check_covariance(covariance: Array) -> None:
    np.testing.assert_allclose(covariance, covariance.T, rtol=1e-9, atol=1e-15)
    values = np.linalg.eigvalsh(covariance)
    assert values[0] >= -1e-12 * max(values[-1], 1)
