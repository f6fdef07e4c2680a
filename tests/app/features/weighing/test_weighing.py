"""What single poses say of a scan: its rays, their shares, and the landscape of all poses."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from engine_runs import drive, kinematic, run
from particle_robot import sensor_named
from stub_drive import DEFAULTS, ENTRIES, STUB, Drive

from app.features.own_models.guards import OwnSensor
from app.features.own_models.model_file import ModelFile
from app.features.weighing.routes import LOWEST, landscape_message, pose_fits
from robot.geometry import Pose2
from robot.localization.landscape import by_heading, landscape
from robot.localization.models.sensor_models import SENSOR_MODELS, sensor_model
from robot.localization.weighing import Weighing
from robot.scan import Scan

TRUE = Pose2(0.05, -0.03, 0.2)
POSES = np.array([[0.05, -0.03, 0.2], [0.06, -0.03, 0.2], [0.05, -0.02, 0.3], [1.0, 1.0, 2.0]])


def scan_at_true() -> Scan:
    return Drive(TRUE, rng=np.random.default_rng(0)).scan()


def weighing(name: str = "likelihood_field") -> Weighing:
    return Weighing(scan_at_true(), sensor_named(name), 0.2, TRUE)


@pytest.mark.parametrize("name", SENSOR_MODELS)
def test_the_shares_of_the_rays_are_the_log_likelihood(name: str) -> None:
    asked = weighing(name).settled(POSES)
    shares, logs = asked.shares(POSES), asked.log_likelihoods(POSES)
    assert np.nansum(shares, axis=1) == pytest.approx(logs, abs=1e-3)
    assert logs == pytest.approx(asked.model.log_likelihood(POSES, asked.scan), abs=1.5)
    counted = np.flatnonzero(~np.isnan(shares[0]))
    assert counted.tolist() == asked.counted.tolist()
    assert len(counted) == 60  # max_beams, of 61 rays
    assert logs.argmax() == 0


def test_skipped_rays_do_not_count_whatever_pose_is_asked() -> None:
    parameters = replace(
        DEFAULTS.sensor, laser_model_type="likelihood_field_prob", do_beamskip=True
    )
    seen = scan_at_true()
    ranges = seen.ranges.copy()
    ranges[25:30] -= 0.08  # a shoe
    spoilt = replace(seen, ranges=ranges)
    model = sensor_model(parameters, ENTRIES, STUB.edges)
    cloud = TRUE.to_array() + np.random.default_rng(1).normal(0, 0.002, (200, 3))
    asked = Weighing(spoilt, model, 0.2, TRUE).settled(cloud)
    assert np.isinf(asked.scan.ranges).sum() == 5
    assert np.isnan(asked.shares(POSES)[0]).sum() == 5
    assert asked.log_likelihoods(cloud) == pytest.approx(
        model.log_likelihood(cloud, spoilt), abs=1e-3
    )


def test_expected_ranges_are_those_that_would_be_measured() -> None:
    asked = weighing()
    expected = asked.expected(TRUE, STUB.edge_index, 1.0)
    both = np.isfinite(expected) & asked.scan.hit
    assert both.sum() > 30
    assert (np.isfinite(expected) == asked.scan.hit).all()
    assert np.abs(expected - asked.scan.ranges)[both].max() < 0.002
    away = asked.expected(TRUE @ Pose2(0.02), STUB.edge_index, 1.0)
    assert np.nanmedian((expected - away)[both]) == pytest.approx(0.02, abs=0.004)


def test_a_ray_sees_only_from_where_its_sight_begins() -> None:
    asked = weighing()
    sight = np.tile([0.45, 1.0], (len(asked.scan.ranges), 1))
    sight[0] = np.nan
    blind = replace(asked, scan=replace(asked.scan, sight=sight))
    expected = blind.expected(TRUE, STUB.edge_index, 1.0)
    assert np.isinf(expected[0]) and expected.min() >= 0.45


# --- landscapes


def test_the_landscape_is_the_model_in_each_cell_and_highest_at_the_robot() -> None:
    asked = weighing()
    area = landscape(asked, STUB.drive_area, TRUE.theta)
    rows, columns = area.logs.shape
    assert rows * columns <= 90_000
    row, column = np.unravel_index(area.logs.argmax(), area.logs.shape)
    best = area.origin[0] + column * area.step, area.origin[1] + row * area.step
    assert best == pytest.approx((TRUE.x, TRUE.y), abs=area.step)
    for row, column in ((3, 7), (rows - 1, columns - 1)):
        x, y = area.origin[0] + column * area.step, area.origin[1] + row * area.step
        one = asked.log_likelihoods(np.array([[x, y, TRUE.theta]]))[0]
        assert area.logs[row, column] == pytest.approx(0.2 * one, abs=1e-4)


def test_a_slow_model_gets_larger_cells(monkeypatch) -> None:
    asked = weighing()
    fine = landscape(asked, STUB.drive_area, 0.0)
    monkeypatch.setattr("robot.localization.landscape._seconds", lambda *_: 1e-3)
    coarse = landscape(asked, STUB.drive_area, 0.0)
    assert coarse.logs.size <= 600 < fine.logs.size


def test_the_right_heading_stands_out_at_the_robots_place() -> None:
    thetas, logs = by_heading(weighing(), TRUE.x, TRUE.y)
    assert thetas[logs.argmax()] == pytest.approx(TRUE.theta, abs=0.02)


# --- from a running program


@pytest.fixture(scope="module")
def snapshot():
    program = kinematic(map="square")
    return program.field, run(program, 2.0, drive(v=0.1, omega=0.3))[-1]


def test_the_estimate_fits_better_than_a_ghost_and_its_rays_say_why(snapshot) -> None:
    field, shown = snapshot
    pose = shown.filter.weighing.best
    ghost = pose.x + 0.01, pose.y, pose.theta
    fits = pose_fits(shown, shown.filter.weighing, field, ghost)
    assert fits.best is not None and fits.particle is None
    assert (fits.best.x, fits.best.y, fits.best.weight) == (pose.x, pose.y, 1.0)
    assert fits.asked.weight < 0.9
    assert fits.asked.weight == pytest.approx(
        np.exp(fits.power * (fits.asked.log_likelihood - fits.best.log_likelihood))
    )
    for fit in (fits.asked, fits.best):
        assert abs(fit.rest) < 0.01
        assert len(fit.expected) == len(fit.shares) == len(fits.ranges) == len(fits.bearings)
    errors = [
        abs(expected - measured)
        for expected, measured in zip(fits.best.expected, fits.ranges, strict=True)
        if expected is not None and measured is not None
    ]
    assert np.median(errors) < 0.002


def test_without_a_heading_the_nearest_particle_is_asked(snapshot) -> None:
    field, shown = snapshot
    particle = shown.filter.cloud.poses[7]
    fits = pose_fits(shown, shown.filter.weighing, field, (particle[0], particle[1], None))
    asked = [fits.asked.x, fits.asked.y, fits.asked.theta]
    assert asked == pytest.approx(particle.tolist(), abs=1e-12)  # headings are wrapped again
    mean = shown.filter.cloud.weights[7] * len(shown.filter.cloud.weights)
    assert fits.particle == pytest.approx(mean)


def test_a_landscape_says_where_it_is_best_and_how_long_it_took(snapshot) -> None:
    field, shown = snapshot
    message = landscape_message(shown, shown.filter.weighing, field, None)
    assert message.theta == shown.filter.weighing.best.theta
    assert np.hypot(message.best.x - shown.truth.x, message.best.y - shown.truth.y) < 0.012
    assert 0 < message.seconds < 5 and message.lowest == LOWEST


OWN = """
import numpy as np

class Failing:
    def __init__(self):
        self.calls = 0

    def log_likelihood(self, poses, scan):
        self.calls += 1
        if self.calls > 1:
            raise ValueError("no more")
        return -np.abs(poses[:, 0]) - 1.0
"""


def test_what_fails_when_it_is_asked_beside_the_robot_does_not_stop_it(save) -> None:
    file = ModelFile.find(f"{save(OWN)}:Failing")
    namespace: dict = {}
    exec(OWN, namespace)
    own = OwnSensor(file, namespace["Failing"]())
    asked = Weighing(scan_at_true(), own.apart(), 0.2, TRUE)
    assert asked.log_likelihoods(POSES).tolist() == (-np.abs(POSES[:, 0]) - 1.0).tolist()
    assert np.nanmax(asked.shares(POSES)) == 0.0  # neutral, once it has failed
    assert asked.model.guard.fault is not None  # type: ignore[attr-defined]
    assert own.guard.fault is None
