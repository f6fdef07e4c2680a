"""A simulated robot's pictures: of the right moment, and rendered beside the engine's work."""

from __future__ import annotations

import threading
from dataclasses import replace

import numpy as np
import pytest
from places import MAPS

from app.engine.robots import build_robot
from app.settings.config import Config
from robot.description.spec import RobotSpec
from robot.driving.differential_drive import DifferentialDrive
from robot.fields.field_loading import load_field
from robot.geometry import Pose2, Twist2
from sim.floor_camera import CameraSettings, FloorCamera
from sim.imperfections import Imperfections
from sim.simulated import SimSettings, SimulatedRobot, no_wait

SPEC = RobotSpec.load()
START = Pose2(0.1, 0.2, 0.3)
FIELD = replace(load_field("square", MAPS), start=START)
TWIST = Twist2(0.1, 0.8)


def robot_with(camera: CameraSettings) -> SimulatedRobot:
    """A perfect robot that has driven an arc from the start on."""
    config = Config(
        robot="kinematic", sim=SimSettings(camera=camera, imperfections=Imperfections.none())
    )
    robot = build_robot(config, SPEC, FIELD, np.random.default_rng(0), no_wait)
    robot.write(DifferentialDrive(SPEC).wheels(TWIST))
    return robot


@pytest.mark.slow
@pytest.mark.parametrize("delay", [0.0, 0.005, 0.2])
@pytest.mark.parametrize("frame_rate", [7, 30, 120])
def test_a_picture_shows_what_there_was_at_its_stamp(delay: float, frame_rate: float) -> None:
    settings = CameraSettings(noise=0, delay=delay, frame_rate=frame_rate)
    robot = robot_with(settings)
    camera = FloorCamera(SPEC.floor_view, FIELD.floor, settings, np.random.default_rng(1))
    frames = [frame for frame in (robot.read().frame for _ in range(40)) if frame]
    until_here = settings.exposure / 2 + SPEC.lens.readout / 2 + delay
    assert len(frames) >= (0.8 - until_here) * min(frame_rate, 50) - 2
    for frame in frames:
        if frame.stamp > 0.01:  # the first step starts from rest
            there = START @ TWIST.integrate(frame.stamp)
            error = np.abs(frame.image.astype(int) - camera.picture(there, TWIST))
            assert error.max() <= 1, "rounding"


def test_pictures_are_rendered_while_the_engine_goes_on() -> None:
    robot = robot_with(CameraSettings())
    threads = set()

    def expose(*moment: object, real=robot._camera.expose) -> object:
        threads.add(threading.current_thread())
        return real(*moment)

    robot._camera.expose = expose  # type: ignore[method-assign]
    for _ in range(10):
        robot.read()
    assert threads and threading.current_thread() not in threads


def test_a_closed_robot_leaves_no_thread() -> None:
    before = set(threading.enumerate())
    robot = robot_with(CameraSettings())
    while robot.read().frame is None:
        pass
    (renderer,) = set(threading.enumerate()) - before
    robot.close()
    assert not renderer.is_alive()


def test_a_picture_that_was_being_rendered_is_lost_when_the_robot_is_placed_elsewhere() -> None:
    robot = robot_with(CameraSettings(delay=0.1))
    while robot.read().frame is None:
        pass
    placed = robot.stamp
    robot.place(Pose2())
    later = [frame for frame in (robot.read().frame for _ in range(30)) if frame]
    assert later and min(frame.stamp for frame in later) > placed
