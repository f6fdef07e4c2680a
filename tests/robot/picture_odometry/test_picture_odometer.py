"""Motion between two rendered pictures of a known floor, without wheels."""

from functools import cache

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from robot.description.spec import RobotSpec
from robot.fields.floor_picture import FloorPicture
from robot.geometry import Pose2, Twist2
from robot.interface import Frame
from robot.picture_odometry.ground import GroundError, GroundView
from robot.picture_odometry.odometer import UNKNOWN, PictureMotion, PictureOdometer
from robot.picture_odometry.settings import PictureOdometrySettings
from sim.floor_camera import CameraSettings, FloorCamera

VIEW = RobotSpec.load().floor_view
SETTINGS = PictureOdometrySettings()
PERIOD = 1 / 30


@cache
def camera(texture: str, tape: bool = False) -> FloorCamera:
    image = np.full((700, 700), 213, dtype=np.uint8)
    if tape:
        image[:, 570:620] = 32  # across the robot's way, 0.22 to 0.27 m before the middle
    floor = FloorPicture(image, 0.001, (-0.35, -0.35, 0.35, 0.35))
    return FloorCamera(VIEW, floor, CameraSettings(texture=texture), np.random.default_rng(7))


def moved(
    twist: Twist2,
    predicted: Pose2 | None = None,
    texture: str = "lino",
    *,
    tape: bool = False,
    start: Pose2 = Pose2(),
) -> tuple[PictureMotion, np.ndarray]:
    """Return what two pictures tell of a motion, and how far that is off (3,)."""
    true = twist.integrate(PERIOD)
    eye = camera(texture, tape)
    odometer = PictureOdometer(VIEW, SETTINGS)
    for count, pose in enumerate((start, start @ true)):
        found = odometer.measure(Frame(count * PERIOD, eye.picture(pose, twist)), predicted or true)
    assert found is not None
    apart = found.motion.inverse() @ true
    return found, apart.to_array()


@settings(max_examples=12, deadline=None, suppress_health_check=list(HealthCheck))
@given(
    v=st.floats(-0.2, 0.3),
    omega=st.floats(-1.0, 1.0),
    texture=st.sampled_from(("wood", "lino")),
    off=st.tuples(st.floats(-1, 1), st.floats(-1, 1), st.floats(-1, 1)),
)
def test_motion_is_found_whatever_the_wheels_say_of_it(v, omega, texture, off):
    twist = Twist2(v, omega)
    wheels = twist.integrate(PERIOD) @ Pose2(0.002 * off[0], 0.001 * off[1], 0.01 * off[2])
    found, apart = moved(twist, wheels, texture)
    assert found.seen == 3
    assert np.hypot(*apart[:2]) < 0.0005 and abs(apart[2]) < np.radians(0.15)


def test_steps_are_off_by_less_than_a_third_of_a_millimetre_and_say_so():
    rng = np.random.default_rng(11)
    off, nees = [], []
    for _ in range(20):
        twist = Twist2(rng.uniform(0, 0.2), rng.uniform(-0.8, 0.8))
        found, apart = moved(twist, start=Pose2(0, 0, rng.uniform(-3, 3)))
        off.append(apart)
        nees.append(apart @ np.linalg.solve(found.covariance, apart))
    rms = np.sqrt(np.mean(np.square(off), axis=0))
    assert np.hypot(*rms[:2]) < 0.0003 and rms[2] < np.radians(0.1)
    assert 0.8 < np.median(nees) < 4.5  # 2.4 of an honest covariance


def test_a_robot_that_stands_while_its_wheels_turn_is_seen_to_stand():
    wheels = Twist2(0.15, 0.0).integrate(PERIOD)
    found, apart = moved(Twist2(), wheels)
    assert found.seen == 3 and np.abs(apart[:2]).max() < 0.0003


def test_a_robot_that_is_pushed_while_its_wheels_stand_is_seen_to_move():
    found, apart = moved(Twist2(0.25, 0.0), Pose2())
    assert found.seen == 3 and np.abs(apart[:2]).max() < 0.0005


def test_a_bare_floor_has_nothing_to_see():
    for start in (Pose2(), Pose2(0.02, 0.01, 0.3), Pose2(-0.05, 0.0, 1.0)):
        wheels = Pose2(0.004, 0.0, 0.01)
        found, _ = moved(Twist2(0.15, 0.2), wheels, "none", start=start)
        assert found.seen == 0
        assert found.motion == wheels
        assert np.diag(found.covariance).min() >= 0.9 * UNKNOWN**2


def test_along_an_edge_only_what_is_across_is_seen():
    wheels = Twist2(0.10, 0.0).integrate(PERIOD) @ Pose2(0.001, 0.002, 0.0)
    found, apart = moved(Twist2(0.10, 0.0), wheels, "none", tape=True)
    assert found.seen == 2
    assert abs(apart[0]) < 0.0004  # the edge lies across: forward is seen
    assert found.covariance[1, 1] > 0.1 * UNKNOWN**2  # and along it is not
    assert np.isclose(found.motion.y, wheels.y, atol=0.0005)


def test_where_only_edges_of_tape_are_seen_a_motion_is_no_more_exact_than_it_says():
    rng = np.random.default_rng(12)
    nees = []
    while len(nees) < 40:
        twist = Twist2(rng.uniform(0, 0.2), rng.uniform(-0.8, 0.8))
        true = twist.integrate(PERIOD)
        wheels = true @ Pose2(*rng.normal(0, (1e-4, 1e-5, 2e-3)).tolist())
        start = Pose2(*rng.uniform(-0.04, 0.04, 2).tolist(), rng.uniform(-0.5, 0.5))
        found, apart = moved(twist, wheels, "none", tape=True, start=start)
        if found.seen >= 2:
            nees.append(apart @ np.linalg.solve(found.covariance, apart))
    assert np.quantile(nees, 0.9) < 7.8  # the 95 % quantile of an honest covariance


def test_the_first_picture_tells_nothing():
    odometer = PictureOdometer(VIEW, SETTINGS)
    assert odometer.measure(Frame(0.0, camera("lino").picture(Pose2(), Twist2())), Pose2()) is None


def test_a_floor_that_the_camera_does_not_see_is_refused():
    with pytest.raises(GroundError, match="of it it sees x"):
        GroundView.of(VIEW, PictureOdometrySettings(nearest=0.02, farthest=0.3))


def test_the_floor_from_above_shows_what_lies_where():
    """A dark square of 2 cm, 0.25 m before the robot and 4 cm to its left."""
    image = np.full((1400, 1400), 213, dtype=np.uint8)
    image[700 - 50 : 700 - 30, 700 + 240 : 700 + 260] = 32
    floor = FloorPicture(image, 0.001, (-0.7, -0.7, 0.7, 0.7))
    perfect = CameraSettings(noise=0, blur=0, vignetting=0)
    picture = FloorCamera(VIEW, floor, perfect, np.random.default_rng(0)).picture(Pose2(), Twist2())
    ground = GroundView.of(VIEW, SETTINGS)
    above = ground.project(picture)
    rows, columns = np.nonzero(above < 120)
    x = ground.corner[0] - ground.resolution * rows.mean()
    y = ground.corner[1] - ground.resolution * columns.mean()
    assert (x, y) == pytest.approx((0.25, 0.04), abs=0.0006)
    assert len(rows) * ground.resolution**2 == pytest.approx(0.0004, rel=0.08)
