"""Ranges out of rendered pictures are those to the tape in the map, and nothing else is tape."""

from __future__ import annotations

import numpy as np
import pytest
from tape_trials import SCANNER, SQUARE, STILL, VIEW, Trial, camera_of, expected, trial

from robot.camera import FloorView
from robot.geometry import Pose2, Twist2
from robot.interface import Frame
from robot.scanning.line_scanner import LineScanner, LineScannerSettings
from sim.floor_camera import CameraSettings, FloorCamera


@pytest.fixture(scope="module")
def camera() -> FloorCamera:
    return camera_of(SQUARE)


@pytest.fixture(scope="module")
def nominal(camera: FloorCamera) -> Trial:
    return trial(SQUARE, camera)


def test_ranges_are_exact_to_a_fraction_of_a_millimetre(nominal: Trial) -> None:
    errors = nominal.errors
    assert len(errors) > 2500
    assert abs(errors.mean()) < 0.1e-3
    assert errors.std() < 0.2e-3
    assert np.percentile(np.abs(errors), 99) < 0.6e-3


def test_no_return_is_far_off_and_hardly_any_tape_is_missed(nominal: Trial) -> None:
    assert nominal.false == 0
    off = np.abs(nominal.ranges[nominal.hit] - nominal.begins[nominal.hit])
    assert off.max() < 0.03
    assert nominal.clear.sum() > 2000
    assert nominal.missed < 0.01


def test_the_width_across_the_line_is_that_of_the_tape(nominal: Trial) -> None:
    widths = nominal.widths[nominal.hit & nominal.clear]
    assert abs(widths.mean() - 0.050) < 0.2e-3
    assert widths.std() < 1.0e-3


def test_rays_may_start_ahead_of_the_axle(camera: FloorCamera) -> None:
    scanner = LineScanner(VIEW, LineScannerSettings(centre_x=0.06, rays=61))
    found = trial(SQUARE, camera, scanner, count=15)
    assert abs(found.errors.mean()) < 0.1e-3 and found.errors.std() < 0.25e-3
    assert found.false == 0
    scan = scanner.scan(Frame(0.0, camera.picture(Pose2(), STILL))).scan
    assert scan.robot_from_scan == Pose2(0.06)
    np.testing.assert_allclose(scan.points()[:, 0], 0.475, atol=2e-3)


@pytest.mark.slow
@pytest.mark.parametrize("twist", [Twist2(0.3, 0), Twist2(0.15, 0.79), Twist2(0, -2)])
def test_the_twist_undoes_the_skew_of_the_rolling_shutter(twist: Twist2) -> None:
    """By quantiles: where a ray all but runs along the tape, a little turn is a long way."""
    camera = camera_of(SQUARE, CameraSettings(exposure=0))
    backwards = Twist2(-twist.v, -twist.omega)
    told, silent, wrong = (
        np.abs(trial(SQUARE, camera, count=20, twist=twist, told=said).errors)
        for said in (twist, STILL, backwards)
    )
    assert np.median(told) < 0.15e-3
    assert np.percentile(told, 95) < 0.8e-3
    assert np.percentile(silent, 80) > 4 * np.percentile(told, 80)
    assert np.percentile(wrong, 80) > 1.7 * np.percentile(silent, 80)


@pytest.mark.parametrize("omega", [1.8, -1.8])
def test_beside_a_corner_a_turning_robot_takes_no_edge_to_be_longer_than_it_is(
    omega: float,
) -> None:
    """Ranges were up to 19 mm too far, where the line of an edge went on behind the corner.

    A robot that saw one side of a square only, and then its corner, was 17 mm off along that side.
    """
    camera, worst = camera_of(SQUARE), []
    for theta in np.linspace(0.6, 1.1, 21):
        robot = Pose2(0.34, -0.006, theta)
        picture = camera.picture(robot, Twist2(0.0, omega))
        scan = SCANNER.scan(Frame(0.0, picture), Twist2(0.0, omega)).scan
        begins, _ = expected(SQUARE, robot, SCANNER)
        assert scan.hit.sum() > 25
        worst.append(np.abs(scan.ranges[scan.hit] - begins[scan.hit]).max())
    assert max(worst) < 0.006


def test_the_blur_of_driving_moves_no_edge(camera: FloorCamera) -> None:
    moving = trial(SQUARE, camera, count=20, twist=Twist2(0.15, 0.79))
    assert abs(moving.errors.mean()) < 0.2e-3
    assert moving.errors.std() < 1.0e-3
    assert moving.false == 0 and moving.missed < 0.05


def test_strong_noise_costs_few_returns_and_makes_hardly_a_false_one() -> None:
    """The kernel and the threshold follow the noise that is measured."""
    noisy = camera_of(SQUARE, CameraSettings(noise=15))
    found = trial(SQUARE, noisy)
    assert found.missed <= 0.05 and found.false <= 0.01
    assert abs(found.errors.mean()) < 0.15e-3 and found.errors.std() < 0.8e-3
    picture = noisy.picture(Pose2(0.1, 0, 0.3), STILL)
    assert 13 < SCANNER.scan(Frame(0.0, picture)).noise < 17


def test_a_soft_picture_costs_little() -> None:
    """Out of focus: edges are 4 pixels wide."""
    soft = trial(SQUARE, camera_of(SQUARE, CameraSettings(blur=2)), count=20)
    assert abs(soft.errors.mean()) < 0.3e-3 and soft.errors.std() < 0.6e-3
    assert soft.missed < 0.03 and soft.false == 0


@pytest.mark.slow
@pytest.mark.parametrize(("exposure", "sd"), [(0.010, 0.3e-3), (0.030, 1.5e-3)])
def test_a_long_exposure_costs_little(exposure: float, sd: float) -> None:
    camera = camera_of(SQUARE, CameraSettings(exposure=exposure))
    moving = trial(SQUARE, camera, count=20, twist=Twist2(0.15, 0.4))
    assert abs(moving.errors.mean()) < 0.3e-3 and moving.errors.std() < sd
    assert moving.missed < 0.05 and moving.false < 0.005


@pytest.mark.parametrize(("degrees", "wide"), [(-0.5, True), (0.5, False)])
def test_the_tape_seems_wider_or_narrower_to_a_camera_that_is_pitched_otherwise(
    camera: FloorCamera, degrees: float, wide: bool
) -> None:
    turn = np.eye(4)
    angle = np.radians(degrees)
    turn[:3, :3] = [
        [np.cos(angle), 0, np.sin(angle)],
        [0, 1, 0],
        [-np.sin(angle), 0, np.cos(angle)],
    ]
    pitched = VIEW.robot_from_camera.copy()
    pitched[:3, :3] = turn[:3, :3] @ pitched[:3, :3]
    scanner = LineScanner(FloorView(VIEW.lens, pitched), LineScannerSettings())
    seen = [
        scanner.scan(Frame(0.0, camera.picture(pose, STILL))).tape_width
        for pose in (Pose2(), Pose2(0, 0, 0.5), Pose2(0.1, 0.1, 1.6))
    ]
    assert (np.median(seen) > 0.051) == wide
    assert (np.median(seen) < 0.049) == (not wide)
    true = SCANNER.scan(Frame(0.0, camera.picture(Pose2(), STILL))).tape_width
    assert true == pytest.approx(0.05, abs=0.3e-3)


def test_light_that_falls_off_to_one_side_does_not_matter(camera: FloorCamera) -> None:
    dim = trial(SQUARE, camera, count=20, light=np.linspace(0.35, 1.15, 640)[None])
    assert abs(dim.errors.mean()) < 0.1e-3 and dim.errors.std() < 0.25e-3
    assert dim.false == 0 and dim.missed < 0.04


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "false", "missed"),
    [("discs", 0.002, 0.02), ("cable", 0.002, 0.04), ("shadow", 0.001, 0.02), ("shoes", 0.002, 1)],
)
def test_things_on_the_floor_are_not_tape(kind: str, false: float, missed: float) -> None:
    """Of shoes, misses are not counted: they stand on the tape."""
    hit = bad = clear = lost = 0
    for seed in range(3):
        rng = np.random.default_rng(seed)
        camera = FloorCamera(VIEW, SQUARE.floor, CameraSettings(clutter=kind), rng)
        found = trial(SQUARE, camera, count=20, seed=seed)
        hit, bad = hit + found.hit.sum(), bad + round(found.false * found.hit.sum())
        clear, lost = clear + found.clear.sum(), lost + (found.clear & ~found.hit).sum()
    assert hit > 2000
    assert bad / hit <= false
    assert lost / clear <= missed


def test_discs_are_in_the_way() -> None:
    """What the checks of straightness and width are for."""
    camera = camera_of(SQUARE, CameraSettings(clutter="discs"))
    blind = LineScanner(VIEW, LineScannerSettings(straightness=0.1, taper=0.5))
    assert trial(SQUARE, camera, blind, count=20).false > 0.03
