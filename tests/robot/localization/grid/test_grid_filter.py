"""The grid neither loses small steps nor blurs, and is cut where that can be afforded."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
import shapely
from stub_drive import (
    BEARINGS,
    DEFAULTS,
    ENTRIES,
    MAPS,
    PERIOD,
    SENSOR,
    STUB,
    Drive,
    draw_poses,
    follow,
)

from robot.fields.edges import outline
from robot.fields.field import Field
from robot.fields.field_loading import load_field
from robot.geometry import Pose2, Twist2, mean_pose, pose_covariance
from robot.localization.filter import Cloud
from robot.localization.grid.grid_filter import GridFilter
from robot.localization.models.entry_field import EntryField
from robot.localization.models.motion_models import (
    DifferentialMotion,
    MotionModel,
    StationaryMotion,
)
from robot.localization.models.sensor_models import SensorModel, sensor_model
from robot.scan import Scan

MOTION = DEFAULTS.motion.model()
EXACT = DifferentialMotion(0, 0, 0, 0)
WALL = replace(STUB, edges=outline(shapely.box(0.5, -1.5, 0.55, 1.5)))
"""One straight piece of tape across x: it says nothing of y."""


def sensor_of(of: Field) -> SensorModel:
    entries = EntryField.build(of, resolution=0.005, max_distance=0.15)
    return sensor_model(DEFAULTS.sensor, entries, of.edges)


def filter_of(
    of: Field = STUB,
    sensor: SensorModel = SENSOR,
    motion: MotionModel = MOTION,
    **options: float,
) -> GridFilter:
    start = DEFAULTS.filter.initial_covariance
    share = DEFAULTS.sensor.likelihood_weight
    return GridFilter(motion, sensor, of, start, likelihood_weight=share, **options)  # type: ignore[arg-type]


# --- motion


def test_steps_much_smaller_than_a_box_add_up() -> None:
    f = filter_of(motion=EXACT)
    f.set_pose(Pose2(0.0, 0.0, 0.3), np.zeros((3, 3)))
    there = Pose2(0.0, 0.0, 0.3)
    step = Twist2(0.003, 0.01).integrate(0.1)
    for _ in range(2000):
        f.predict(step)
        there = there @ step
    found = f.hypotheses[0].pose
    assert there.distance_to(Pose2()) > 0.2
    assert found.distance_to(there) < 0.0005 and abs(found.turn_to(there)) < 0.001


def test_steps_without_noise_do_not_blur_it_away() -> None:
    """Two metres on a circle, in 400 steps: a step each would have cost a centimetre."""
    f = filter_of(motion=EXACT)
    f.set_pose(Pose2(), np.zeros((3, 3)))
    before = np.sqrt(np.diag(f.hypotheses[0].covariance))
    for _ in range(400):
        f.predict(Twist2(0.15, 0.79).integrate(PERIOD))
    after = np.sqrt(np.diag(f.hypotheses[0].covariance))
    assert before[0] < 0.002
    assert (after[:2] < 0.006).all() and after[2] < 3 * before[2]


def test_with_noise_it_gets_as_wide_as_particles_do() -> None:
    f, step = filter_of(), Twist2(0.15, 0.79).integrate(PERIOD)
    f.set_pose(Pose2(), np.diag(np.square([0.005, 0.005, 0.01])))
    rng = np.random.default_rng(0)
    poses = draw_poses(rng, Pose2(), (0.005, 0.005, 0.01), 20_000)
    for _ in range(60):
        f.predict(step)
        poses = MOTION.sample(poses, step, rng)
    weights = np.full(len(poses), 1 / len(poses))
    mean = mean_pose(poses, weights)
    expected = np.sqrt(np.diag(pose_covariance(poses, weights, mean)))
    found = f.hypotheses[0]
    assert found.pose.distance_to(mean) < 0.003
    sd = np.sqrt(np.diag(found.covariance))
    assert (sd > 0.95 * expected).all() and (sd < 1.2 * expected).all()


@pytest.mark.parametrize("sd", [1.2, 3.2])
def test_a_step_after_which_it_may_head_anywhere_is_taken(sd: float) -> None:
    f, drive = filter_of(motion=StationaryMotion(0.01, sd)), Drive()
    f.set_pose(drive.true, np.diag(np.square([0.02, 0.02, 0.05])))
    f.predict(Pose2())
    headings = np.unique(f.cloud.poses[:, 2])
    assert len(headings) == 8
    f.correct(drive.scan())
    assert f.hypotheses[0].pose.distance_to(drive.true) < 0.03


# --- scans


def test_told_about_where_it_is_it_ends_in_the_finest_boxes_and_few() -> None:
    f, drive = filter_of(), Drive()
    f.set_pose(Pose2(-0.1, -0.1, 0.3), DEFAULTS.filter.initial_covariance)
    assert f.cell[0] > 0.01
    errors = follow(f, drive, 3.0)
    assert f.cell[0] == pytest.approx(0.00125)
    assert len(f.cloud.weights) < 1000
    assert max(errors[-30:]) < 0.003


@pytest.mark.slow
@pytest.mark.parametrize(
    ("finest_xy", "finest_theta", "within"),
    [(0.0025, 0.35, 0.003), (0.005, 0.7, 0.006), (0.02, 2.8, 0.025)],
)
def test_it_is_right_to_about_a_box_though_scans_are_much_sharper(
    finest_xy: float, finest_theta: float, within: float
) -> None:
    f, drive = filter_of(finest_xy=finest_xy, finest_theta=math.radians(finest_theta)), Drive()
    f.set_pose(drive.true @ Pose2(0.01, 0.01, 0.03), np.diag(np.square([0.02, 0.02, 0.05])))
    assert max(follow(f, drive, 4.0)[30:]) < within


@pytest.mark.slow
@pytest.mark.parametrize("start", [Pose2(), Pose2(-0.2, 0.15, 2.0)], ids=str)
def test_scattered_it_finds_the_one_place(start: Pose2) -> None:
    f, drive = filter_of(), Drive(start)
    f.scatter()
    follow(f, drive, 5.0)
    best = f.hypotheses[0]
    assert best.weight > 0.95
    assert best.pose.distance_to(drive.true) < 0.01
    assert abs(best.pose.turn_to(drive.true)) < 0.02


@pytest.mark.parametrize("name", ["beam", "likelihood_field"])
def test_to_the_beam_model_it_says_much_that_nothing_returned(name: str) -> None:
    """Told to be amid the field, or off it with nothing ahead."""
    sensor = sensor_model(replace(DEFAULTS.sensor, laser_model_type=name), ENTRIES, STUB.edges)
    f = filter_of(sensor=sensor)
    f.set_cloud(Cloud.even(np.array([[0.0, 0, 0], [2.0, 0, 0]])))
    f.correct(Scan(0.0, BEARINGS[:0], np.empty(0)))
    assert [one.weight for one in f.hypotheses] == pytest.approx([0.5, 0.5])
    f.correct(Scan(0.0, BEARINGS, np.full(61, np.inf)))
    amid = sum(one.weight for one in f.hypotheses if one.pose.x < 1)
    assert amid == pytest.approx(0.5 if name == "likelihood_field" else 0.0, abs=1e-3)


@pytest.mark.slow
def test_scattered_over_a_square_it_keeps_all_four_places() -> None:
    square = load_field("square", MAPS)
    f, drive = filter_of(square, sensor_of(square)), Drive(edges_of=square)
    f.scatter()
    follow(f, drive, 2.0)
    assert len(f.hypotheses) == 4
    for quarter in range(4):
        there = Pose2(0, 0, quarter * math.pi / 2) @ drive.true
        (weight,) = [one.weight for one in f.hypotheses if one.pose.distance_to(there) < 0.01]
        assert 0.15 < weight < 0.4


def test_it_learns_nothing_along_a_wall() -> None:
    f = filter_of(WALL, sensor_of(WALL))
    f.set_pose(Pose2(0.1, 0.0, 0.0), np.diag(np.square([0.02, 0.02, 0.05])))
    for _ in range(20):
        f.correct(Scan(0.0, BEARINGS, 0.4 / np.cos(BEARINGS)))
    (found,) = f.hypotheses
    x, y, theta = np.sqrt(np.diag(found.covariance))
    assert x < 0.002 and theta < 0.005
    assert y == pytest.approx(0.02, rel=0.1)
    assert abs(found.pose.y) < 0.002 and abs(found.pose.x - 0.1) < 0.001


@pytest.mark.parametrize("level", [1, 2, 4])
def test_a_scan_counts_once_however_often_boxes_are_cut_for_it(level: int) -> None:
    """From coarse boxes and from fine ones the belief after a scan is the same.

    If the scan tells more than what was known, of which coarse boxes keep less.
    """
    exact = sensor_model(replace(DEFAULTS.sensor, sigma_slope=0.0), ENTRIES, STUB.edges)
    told, known = Pose2(), np.diag(np.square([0.006, 0.006, 0.02]))
    scan = Drive().scan()
    fine, coarse = (filter_of(sensor=exact, most_cells=100_000) for _ in range(2))
    for f in (fine, coarse):
        f.set_pose(told, known)
    assert fine.cell[0] == 0.00125
    for _ in range(level):
        coarse._grid = coarse._grid.coarser()
    for f in (fine, coarse):
        f.correct(scan)
    one, other = fine.hypotheses[0], coarse.hypotheses[0]
    measured = [0, 2]  # along the wall in sight coarse boxes make it wider
    np.testing.assert_allclose(
        np.diag(other.covariance)[measured], np.diag(one.covariance)[measured], rtol=0.1
    )
    assert one.pose.distance_to(other.pose) < 0.001


def test_it_is_as_wide_as_its_boxes_middles_and_a_box() -> None:
    """Within a box any pose is as likely."""
    f = filter_of(finest_xy=0.02, finest_theta=0.1)
    f.set_pose(Pose2(0.1, 0.1, 0.3), np.zeros((3, 3)))
    cloud = f.cloud
    middles = pose_covariance(cloud.poses, cloud.weights, mean_pose(cloud.poses, cloud.weights))
    claimed = f.hypotheses[0].covariance
    np.testing.assert_allclose(
        np.diag(claimed), np.diag(middles) + np.square(f.cell) / 12, rtol=0.01
    )


def test_on_a_long_way_without_noise_its_boxes_stay_side_by_side() -> None:
    """Poses of neighbouring headings part by 18 mm in three metres."""
    f = filter_of(motion=EXACT)
    f.set_pose(Pose2(-0.5), np.diag([0, 0, 0.03**2]))
    for _ in range(200):
        f.predict(Pose2(0.015))
    y = f.cloud.poses[:, 1]
    filled = np.unique(np.floor(y[np.abs(y) < 0.06] / 0.006))
    assert f.cell[0] < 0.006
    assert len(filled) == 20


@pytest.mark.slow
def test_it_keeps_no_more_boxes_than_it_may() -> None:
    f, drive = filter_of(most_cells=3000), Drive()
    f.scatter()
    for moved, scan in drive.eight(2.0):
        assert len(f._grid.mass) <= 3000
        f.predict(moved)
        assert len(f._grid.mass) <= 3000
        f.correct(scan)


def test_paused_for_long_it_keeps_no_more_boxes_than_it_may() -> None:
    f, drive = filter_of(most_cells=3000), Drive()
    f.set_pose(Pose2(), np.diag(np.square([0.01, 0.01, 0.02])))
    for moved, _ in drive.eight(10.0):
        f.predict(moved)
        assert len(f._grid.mass) <= 3000
    assert f.cell[0] > 0.005
