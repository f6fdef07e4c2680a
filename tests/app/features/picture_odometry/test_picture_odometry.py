"""The picture's odometer in a program: beside the wheels, and in their place."""

import cv2
import numpy as np
import pytest
from engine_runs import PERFECT, drive, kinematic, run

from app.features.picture_odometry.companion import WORDS
from app.features.picture_odometry.routes import SIDES, SIZE_M, floor_jpeg
from robot.description.spec import RobotSpec
from robot.interface import Frame
from robot.picture_odometry.wheel_check import WheelState

ON = {"picture_odometry": {"enabled": True}}
FUSED = {"picture_odometry": {"fuse": True}}


def test_without_the_setting_nothing_is_measured():
    assert "picture_odometry" not in run(kinematic(), 0.1, drive(0.1))[-1].added


def test_measured_alone_it_changes_nothing_of_what_the_program_does():
    before, after = (run(kinematic(seed=3, added=each), 1.0, drive(0.1, 0.3)) for each in ({}, ON))
    assert [one.odom_from_robot for one in before] == [one.odom_from_robot for one in after]
    assert before[-1].pose == after[-1].pose
    shown = after[-1].added["picture_odometry"]
    assert shown.wheels in (WheelState.ROLLING, WheelState.UNKNOWN)
    assert shown.odom_covariance is None


def test_fused_it_has_a_covariance_and_stays_true_to_perfect_wheels():
    shown = run(kinematic(sim=PERFECT, added=FUSED), 1.0, drive(0.1, 0.3))[-1]
    assert shown.odometry.distance_to(shown.truth) < 0.002
    covariance = shown.added["picture_odometry"].odom_covariance
    assert (np.linalg.eigvalsh(covariance) > 0).all()


def test_each_fault_of_wheels_has_words():
    assert set(WORDS) == set(WheelState) - {WheelState.ROLLING, WheelState.UNKNOWN}


@pytest.mark.parametrize("colours", [(), (3,)])
def test_the_floor_from_above_is_one_millimetre_a_pixel(colours):
    view = RobotSpec.load().floor_view
    frame = Frame(0.0, np.full((view.lens.height, view.lens.width, *colours), 90, dtype=np.uint8))
    data = np.frombuffer(floor_jpeg(view, frame), dtype=np.uint8)
    above = cv2.imdecode(data, cv2.IMREAD_UNCHANGED)
    nearest, farthest, wide = SIDES
    assert above.shape == pytest.approx(((farthest - nearest) / SIZE_M, wide / SIZE_M), abs=1)
    assert abs(int(above[200, 180]) - 90) <= 2  # in view
    assert above[-1, 0] < 20  # beside the camera's view, close to the robot
