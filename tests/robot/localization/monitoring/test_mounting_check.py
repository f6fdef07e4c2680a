"""A camera that is askew shows in what no pose explains."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
from stub_drive import BEARINGS, MAPS, PERIOD, Drive

from robot.description.spec import RobotSpec
from robot.fields.field import Field
from robot.fields.field_loading import load_field
from robot.fields.ray_casting import cast_toward
from robot.geometry import Pose2, heading_angles
from robot.localization.monitoring.causes import TILT_EXPLAINS
from robot.localization.monitoring.monitor import Monitor
from robot.localization.monitoring.mounting_check import (
    LASER,
    ApparentErrors,
    CameraPosition,
    MountingCheck,
)
from robot.localization.monitoring.scan_residuals import residual_sums
from robot.localization.ray_evidence import RayEvidence
from robot.localization.scan_matching import ScanMatcher
from robot.scan import Scan, rays_of

FROM_CAMERA = RobotSpec.load().floor_view.robot_from_camera
CAMERA = CameraPosition(float(FROM_CAMERA[0, 3]), float(FROM_CAMERA[2, 3]))
FIELDS = {name: load_field(name, MAPS) for name in ("stub", "tee")}
HALF_A_DEGREE = math.radians(0.5)
RANGE_MAX = 1.0
NEAR = 0.15
"""Nearer than this the camera does not see the floor [m]."""
ACROSS = 0.00003
"""How far the line scanner's ends lie off near edges [m]."""


def askew(scan: Scan, pitch: float, roll: float) -> Scan:
    """The scan as a camera reports it whose mounting is off [rad]."""
    hit = scan.hit
    ends = scan.points()
    ends = ends + CAMERA.shifts(ends) @ np.array([pitch, roll])
    bearings, ranges = scan.bearings.copy(), scan.ranges.copy()
    bearings[hit], ranges[hit] = heading_angles(ends), np.hypot(*ends.T)
    return replace(scan, bearings=bearings, ranges=ranges)


def scans_of(of: Field, seed: int, seconds: float) -> Iterator[tuple[Pose2, Scan]]:
    """Scans whose ends err across edges as the line scanner's do: more where the floor is far."""
    drive = Drive(Pose2(0, 0, 0.4 * seed), edges_of=of, rng=np.random.default_rng(seed))
    sight = np.tile([NEAR, np.inf], (len(BEARINGS), 1))
    for _ in drive.eight(seconds):
        ranges = np.array([met(of, drive, bearing) for bearing in BEARINGS])
        yield drive.true, Scan(drive.stamp, BEARINGS, ranges, sight=sight)


def met(of: Field, drive: Drive, bearing: float) -> float:
    """Where a ray ends [m]."""
    heading = drive.true.theta + bearing
    dx, dy = math.cos(heading), math.sin(heading)
    x, y = drive.true.x + NEAR * dx, drive.true.y + NEAR * dy
    away, edge = cast_toward(x, y, dx, dy, of.edge_index, RANGE_MAX - NEAR)
    if edge < 0:
        return math.inf
    ex, ey = of.edges[edge, 2:] - of.edges[edge, :2]
    sine = max(abs(dx * ey - dy * ex) / math.hypot(ex, ey), 0.1)
    length = NEAR + away
    return float(length + ACROSS * (1 + 25 * length**2) * drive.rng.standard_normal() / sine)


def checked(
    of: Field, pitch: float, roll: float, seconds: float = 3.0, seed: int = 0
) -> tuple[MountingCheck, ApparentErrors]:
    """What is found where poses are fitted to scans and tilt is taken off, as the program does."""
    sd = 0.0005
    matcher = ScanMatcher(of.edge_index, RANGE_MAX, sd, gate=0.06, slope=25.0)
    check = MountingCheck()
    for true, scan in scans_of(of, seed, seconds):
        off_pitch, off_roll = check.applied.tolist()
        seen = rays_of(askew(scan, pitch - off_pitch, roll - off_roll), 91)
        pose = matcher.match(true, seen).pose.to_array()
        sums, used, _ = residual_sums(
            pose, seen, of.edge_index, RANGE_MAX, CAMERA.x, CAMERA.height,
            off_pitch, off_roll, check.exactness,
        )  # fmt: skip
        check.observe(sums, used, PERIOD)
        error = check.error
        check.follow()
    return check, error


@pytest.mark.slow
@pytest.mark.parametrize("name", FIELDS)
@pytest.mark.parametrize(
    ("pitch", "roll"),
    [(0.5, 0.0), (-0.5, 0.0), (0.0, 0.5), (0.35, -0.35)],
    ids=["pitched", "pitched up", "rolled", "both"],
)
def test_a_tilt_of_half_a_degree_is_found_in_seconds(name: str, pitch: float, roll: float) -> None:
    for seed in range(2):
        _, error = checked(FIELDS[name], math.radians(pitch), math.radians(roll), seed=seed)
        assert math.degrees(error.pitch) == pytest.approx(pitch, abs=0.1)
        assert math.degrees(error.roll) == pytest.approx(roll, abs=0.1)
        # On the stub a roll leaves about as much as it explains: it is corrected, and not told.
        assert error.explained > (0.4 if (name, pitch) == ("stub", 0.0) else TILT_EXPLAINS)


@pytest.mark.parametrize("name", FIELDS)
def test_of_a_camera_that_is_as_drawn_nothing_is_found_or_taken_off(name: str) -> None:
    for seed in range(3):
        check, error = checked(FIELDS[name], 0.0, 0.0, seed=seed)
        assert math.degrees(error.tilt) < 0.05
        assert abs(error.scale) < 0.002
        np.testing.assert_array_equal(check.applied, 0)


def test_noise_alone_is_no_tilt(monkeypatch: pytest.MonkeyPatch) -> None:
    """Three times as much of it; rays that graze err most."""
    monkeypatch.setitem(globals(), "ACROSS", 3 * ACROSS)
    for seed in (1, 3):
        _, error = checked(FIELDS["tee"], 0.0, 0.0, seed=seed)
        assert math.degrees(error.tilt) < 0.08
        assert abs(error.scale) < 0.0005


def test_a_tilt_that_stands_out_is_taken_off_and_the_rest_of_it_is_small() -> None:
    check, error = checked(FIELDS["stub"], HALF_A_DEGREE, 0.0, seconds=4.0)
    assert check.applied[0] == pytest.approx(error.pitch, abs=math.radians(0.02))
    mean, covariance = check.pose_error()
    assert np.hypot(*mean[:2]) < 0.004
    assert (np.linalg.eigvalsh(covariance) >= 0).all()


def test_before_any_scan_a_camera_is_as_carefully_mounted_as_usual() -> None:
    error = MountingCheck().error
    assert error.tilt == error.scale == error.explained == 0
    assert math.degrees(math.sqrt(error.covariance[0, 0])) == pytest.approx(0.3)


def test_a_map_that_is_drawn_too_small_is_no_tilt() -> None:
    """Rays end where the floor has its edges: by 1 % farther than the map says."""
    stub = FIELDS["stub"]
    floor = replace(stub, edges=1.01 * stub.edges)
    matcher = ScanMatcher(stub.edge_index, RANGE_MAX, 0.0005, gate=0.06, slope=25.0)
    check = MountingCheck()
    for true, scan in scans_of(floor, 0, 5.0):
        rays = rays_of(scan, 91)
        small = Pose2(true.x / 1.01, true.y / 1.01, true.theta)
        pose = matcher.match(small, rays).pose.to_array()
        camera = CAMERA.x, CAMERA.height
        sums, used, _ = residual_sums(
            pose, rays, stub.edge_index, RANGE_MAX, *camera, 0.0, 0.0, 1.0
        )
        check.observe(sums, used, PERIOD)
    error = check.error
    assert abs(error.scale) > 0.0015
    assert math.degrees(error.tilt) < 0.25


# --- a ray's row of derivatives


@pytest.mark.parametrize("seed", range(6))
def test_derivatives_are_those_of_an_ends_distance_from_its_edge(
    seed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """By pose, and by the tilt that the scan was taken with."""
    monkeypatch.setitem(globals(), "ACROSS", 0.0)
    stub, rng = FIELDS["stub"], np.random.default_rng(seed)
    drive = Drive(Pose2(*rng.uniform(-0.15, 0.15, 2), rng.uniform(-3, 3)), edges_of=stub, rng=rng)
    pose = drive.true
    ray = int(rng.integers(10, 50))
    clean = Scan(0.0, BEARINGS[ray : ray + 1], np.array([met(stub, drive, BEARINGS[ray])]))
    # So close to the edge that the end is where it is due.
    clean = replace(clean, ranges=clean.ranges + 1e-5)
    heading = pose.theta + BEARINGS[ray]
    dx, dy = math.cos(heading), math.sin(heading)
    _, edge = cast_toward(
        pose.x + NEAR * dx, pose.y + NEAR * dy, dx, dy, stub.edge_index, RANGE_MAX
    )
    x0, y0, x1, y1 = stub.edges[edge]
    normal = np.array([y1 - y0, x0 - x1]) / math.hypot(x1 - x0, y1 - y0)

    def off(at: Pose2, scan: Scan) -> float:
        return float((at.apply(scan.points())[0] - (x0, y0)) @ normal)

    sight = np.array([[NEAR, np.inf]])
    sums, used, returned = residual_sums(
        pose.to_array(), rays_of(replace(clean, sight=sight), 1), stub.edge_index, RANGE_MAX,
        CAMERA.x, CAMERA.height, 0.0, 0.0, 1.0,
    )  # fmt: skip
    assert used == returned == 1
    here, h = off(pose, clean), 1e-6
    row = sums[:, 6] / sums[6, 6] * here
    for axis in range(3):
        there = Pose2.from_array(pose.to_array() + h * np.eye(3)[axis])
        assert row[axis] == pytest.approx((off(there, clean) - here) / h, abs=1e-3)
    for axis in range(2):
        tilted = askew(clean, *(h * np.eye(2)[axis]))
        assert row[3 + axis] == pytest.approx((off(pose, tilted) - here) / h, abs=1e-3)


def test_a_laser_has_no_tilt() -> None:
    stub = FIELDS["stub"]
    true, scan = next(iter(scans_of(stub, 0, 0.1)))
    sums, _, _ = residual_sums(
        true.to_array(), rays_of(scan, 91), stub.edge_index, RANGE_MAX, 0.0, math.inf, 0.0, 0.0, 1.0
    )
    assert not sums[3:5].any() and not sums[:, 3:5].any()
    assert sums[5, 5] > 0


# --- in the monitor


def test_a_scan_is_corrected_by_what_is_taken_off() -> None:
    stub = FIELDS["stub"]
    evidence = RayEvidence.of(stub, RANGE_MAX, 0.005)
    _, scan = next(iter(scans_of(stub, 0, 0.1)))
    tilted = askew(scan, 0.004, -0.003)
    for mounting, mended in ((CAMERA, True), (LASER, False)):
        monitor = Monitor(evidence, mounting)
        assert monitor.corrected(tilted) is tilted
        monitor._camera.applied = np.array([0.004, -0.003])
        corrected = monitor.corrected(tilted)
        away = np.hypot(*(corrected.points() - scan.points()).T).max()
        shifted = np.hypot(*(tilted.points() - scan.points()).T).max()
        # A tilt of a tilt is left.
        assert (away < 0.05 * shifted) == mended
        np.testing.assert_array_equal(corrected.hit, scan.hit)


def test_where_a_scan_tells_nothing_the_pose_stays_as_far_off_as_it_was() -> None:
    """An edge a metre ahead of the origin, then one beside it: each moves its own axis."""
    check = MountingCheck()
    ahead, aside = np.zeros((7, 7)), np.zeros((7, 7))
    ahead[np.ix_([0, 5], [0, 5])] = 1e8  # d = x + scale, with an edge at x = 1
    aside[np.ix_([1, 5], [1, 5])] = 1e8
    check.look(ahead)
    mean, covariance = check.pose_error()
    assert mean == pytest.approx(0)
    assert np.sqrt(covariance.diagonal()) == pytest.approx([0.015, 0, 0], rel=0.05)
    check.look(aside)
    _, covariance = check.pose_error()
    assert np.sqrt(covariance.diagonal()) == pytest.approx([0.015, 0.015, 0], rel=0.05)
    check.look(ahead)
    _, covariance = check.pose_error()
    assert np.sqrt(covariance.diagonal()) == pytest.approx([0.015, 0.015, 0], rel=0.05)


@pytest.mark.parametrize(("at", "sd"), [(1.0, 0.015), (0.5, 0.0127), (-1.0, 0.008)])
def test_a_maps_scale_is_tried_by_edges_that_lie_apart(at: float, sd: float) -> None:
    """An edge a metre ahead of the origin, then one elsewhere: a larger floor has them apart."""
    check = MountingCheck()
    assert check.scale_sd == 0.015
    for edge in (1.0, at, at):
        row = np.array([1.0, 0.0, 0.0, 0.0, 0.0, edge, 0.0])
        check.look(1e8 * np.outer(row, row))
        check.try_scale()
    assert check.scale_sd == pytest.approx(sd, rel=0.01)
    check.forget()  # the robot was moved; the floor is the same
    assert check.scale_sd == pytest.approx(sd, rel=0.01)


@pytest.mark.parametrize("crossing", [0.0, 0.001, 0.01, 0.1])
def test_edges_that_are_nearly_parallel_shift_no_pose_by_metres(crossing: float) -> None:
    """Two edges that cross at a small angle: seen for a second, from a metre beside the origin."""
    check = MountingCheck()
    scan = np.zeros((7, 7))
    for angle, distance in [(0.0, 1.0), (crossing, 1.3)]:
        row = np.array([math.sin(angle), math.cos(angle), 0.0, 0.0, 0.0, -distance, 0.0])
        scan += 1e8 * np.outer(row, row)
    for _ in range(30):
        check.look(scan)
    _, covariance = check.pose_error()
    x, y, _ = np.sqrt(covariance.diagonal())
    assert x < 0.15
    assert 0.015 < y < 0.021
