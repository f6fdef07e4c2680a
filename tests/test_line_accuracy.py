"""Ranges out of rendered pictures are those to the tape in the map, and nothing else is tape."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from tape_trials import SQUARE, STILL, VIEW, Trial, camera_of, drawn, trial

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
    assert errors.std() < 0.25e-3
    assert np.percentile(np.abs(errors), 99) < 1.0e-3


def test_no_return_is_far_off_and_hardly_any_tape_is_missed(nominal: Trial) -> None:
    assert nominal.false == 0
    off = np.abs(nominal.ranges[nominal.hit] - nominal.begins[nominal.hit])
    assert off.max() < 0.03
    assert nominal.clear.sum() > 2000
    assert nominal.missed < 0.03


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


def test_the_blur_of_driving_moves_no_edge(camera: FloorCamera) -> None:
    moving = trial(SQUARE, camera, count=20, twist=Twist2(0.15, 0.79))
    assert abs(moving.errors.mean()) < 0.2e-3
    assert moving.errors.std() < 1.0e-3
    assert moving.false == 0 and moving.missed < 0.05


def test_strong_noise_costs_returns_but_makes_hardly_a_false_one() -> None:
    noisy = camera_of(SQUARE, CameraSettings(noise=15))
    narrow = trial(SQUARE, noisy, count=20)
    assert narrow.false < 0.01
    wide = trial(SQUARE, noisy, LineScanner(VIEW, LineScannerSettings(kernel=5)), count=20)
    assert wide.false < 0.002
    assert abs(wide.errors.mean()) < 0.1e-3 and wide.errors.std() < 0.8e-3
    assert wide.missed < 0.10 < narrow.missed + 0.05


def test_light_that_falls_off_to_one_side_does_not_matter(camera: FloorCamera) -> None:
    dim = trial(SQUARE, camera, count=20, light=np.linspace(0.35, 1.15, 640)[None])
    assert abs(dim.errors.mean()) < 0.1e-3 and dim.errors.std() < 0.25e-3
    assert dim.false == 0 and dim.missed < 0.04


def test_dark_discs_on_the_floor_are_not_tape(tmp_path: Path) -> None:
    """Their chords are as wide as tape somewhere; only their edges are not straight."""
    rng = np.random.default_rng(3)
    discs = "".join(
        f'<circle cx="{x:.0f}" cy="{y:.0f}" r="{r:.1f}" fill="#202225"/>'
        for x, y, r in rng.uniform([-420, -420, 6], [420, 420, 40], (25, 3))
    )
    field = drawn(tmp_path, "discs", discs)
    assert len(field.edges) == len(SQUARE.edges), "fills are not in the map"
    camera = camera_of(field)
    found = trial(field, camera, count=40)
    assert found.hit.sum() > 1200
    assert found.false < 0.01
    blind = LineScanner(VIEW, LineScannerSettings(straightness=0.1))
    assert trial(field, camera, blind, count=40).false > 0.05, "the discs are in the way"
