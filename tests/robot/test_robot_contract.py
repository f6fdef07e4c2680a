"""The contract of a robot: what any must do, for all that there are."""

import os

import cv2
import numpy as np
import pytest
from simulators import require_engine

from app.engine.build import build_program
from app.settings.config import Config
from benchmarks.hat.bricks import Bricks
from robot.cameras.choice import open_camera
from robot.cameras.settings import CameraSourceSettings
from robot.geometry import Pose2
from robot.interface import RepositionableRobot, Robot

PERIOD = 0.02
"""Joints may be read a little before the picture that comes with them."""

ROBOTS = ("sim", "kinematic", "buildhat", *os.environ.get("ROBOTS", "").split())
"""Those of other packages are named in the environment (docs/extending.md)."""


@pytest.fixture(scope="module")
def pictures(tmp_path_factory):
    """A folder of three pictures of the lens's size."""
    folder = tmp_path_factory.mktemp("pictures")
    rng = np.random.default_rng(0)
    for name in "abc":
        cv2.imwrite(str(folder / f"{name}.png"), rng.integers(0, 255, (480, 640), np.uint8))
    return folder


def in_bricks(pictures):
    """The driver of the real robot on an emulated board; time passes while it reads."""
    bricks = Bricks()
    settings = CameraSourceSettings(source=str(pictures))
    camera = open_camera(bricks.spec.lens, settings, lambda: bricks.now)
    made = bricks.robot(camera)
    while not made.read().connected:
        pass
    return made


@pytest.fixture(params=ROBOTS)
def robot(request, pictures):
    if request.param == "sim":
        require_engine()
    hat = request.param == "buildhat"
    made = in_bricks(pictures) if hat else build_program(Config(robot=request.param)).robot
    yield made
    made.close()


def readings(robot, seconds):
    first = robot.read()
    found = [first]
    while found[-1].stamp < first.stamp + seconds:
        found.append(robot.read())
    return found


def driven(robot, velocities, seconds):
    """Readings while the same velocities are asked for after each, as the engine does."""
    robot.write(np.array(velocities))
    found = [robot.read()]
    while found[-1].stamp < found[0].stamp + seconds:
        robot.write(np.array(velocities))
        found.append(robot.read())
    return found


def test_it_is_a_robot(robot):
    assert isinstance(robot, Robot)
    assert robot.name


def test_stamps_rise(robot):
    stamps = [reading.stamp for reading in readings(robot, 1.0)]
    assert np.all(np.diff(stamps) > 0)


def test_arrays_have_one_entry_a_joint(robot):
    reading = robot.read()
    joints = len(robot.spec.joints)
    assert reading.positions.shape == reading.velocities.shape == (joints,)
    assert robot.write(np.zeros(joints)).shape == (joints,)


def test_it_stands_before_the_first_command(robot):
    found = readings(robot, 0.5)
    assert np.abs(found[-1].positions - found[0].positions).max() < np.radians(2)


def test_positive_velocities_drive_forward(robot):
    before = robot.read()
    after = driven(robot, [3.0, 3.0], 1.0)[-1]
    assert np.all(after.positions - before.positions > 2.0)
    if before.truth is not None:
        assert (before.truth.inverse() @ after.truth).x > 0.05


def test_positions_are_not_wrapped(robot):
    assert driven(robot, [8.0, 8.0], 2.0)[-1].positions.min() > 4 * np.pi


def test_velocities_are_reported_and_held(robot):
    last = driven(robot, [4.0, -4.0], 1.0)[-1]
    assert last.velocities == pytest.approx([4.0, -4.0], abs=0.5)


def test_write_returns_what_was_applied_within_the_limits(robot):
    limits = np.array([joint.max_velocity for joint in robot.spec.joints])
    assert robot.write(np.array([1e6, -1e6])) == pytest.approx([limits[0], -limits[1]])
    assert robot.write(np.array([1.0, -1.0])) == pytest.approx([1.0, -1.0])


def test_frames_come_once_each_in_order_with_the_time_of_their_exposure(robot):
    found = readings(robot, 1.0)
    frames = [(r.stamp, r.frame) for r in found if r.frame is not None]
    assert 25 <= len(frames) <= 31
    stamps = [frame.stamp for _, frame in frames]
    assert np.all(np.diff(stamps) > 0)
    assert all(-PERIOD < handed - frame.stamp < 0.1 for handed, frame in frames)


def test_pictures_have_the_size_of_the_lens_and_cannot_be_changed(robot):
    frame = next(r.frame for r in readings(robot, 0.3) if r.frame is not None)
    assert frame.image.shape[:2] == (
        robot.spec.lens.height,
        robot.spec.lens.width,
    )
    assert frame.image.dtype == np.uint8
    with pytest.raises(ValueError, match="read-only"):
        frame.image[0, 0] = 0


def test_close_stops_it_and_may_be_called_twice(robot):
    robot.write(np.full(2, 3.0))
    robot.close()
    robot.close()
    assert not np.any(robot.write(np.full(2, 3.0)))


@pytest.mark.parametrize("name", [name for name in ROBOTS if name != "buildhat"])
def test_a_simulated_robot_waits_for_the_time_of_each_reading(name):
    if name == "sim":
        require_engine()
    waited = []
    robot = build_program(Config(robot=name), waited.append).robot
    stamps = [robot.read().stamp for _ in range(10)]
    robot.close()
    assert waited == pytest.approx(stamps)


def test_what_can_be_placed_stands_where_it_is_placed(robot):
    if not isinstance(robot, RepositionableRobot):
        pytest.skip("this robot can only be moved by hand")
    robot.write(np.full(2, 5.0))
    before = readings(robot, 0.5)[-1]
    robot.write(np.zeros(2))
    robot.place(Pose2(0.3, -0.2, 2.0))
    after = robot.read()
    assert after.truth.distance_to(Pose2(0.3, -0.2, 2.0)) < 1e-3
    assert abs(after.truth.turn_to(Pose2(0.3, -0.2, 2.0))) < 1e-3
    # Being carried is not seen by the wheels.
    assert np.abs(after.positions - before.positions).max() < np.radians(10)
