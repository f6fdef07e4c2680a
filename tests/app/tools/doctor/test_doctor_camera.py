"""What ``brickpose doctor`` finds in a camera."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest

from app.features.build_hat import robot_check
from app.tools.doctor.finding import OK, PROBLEM, WARNING
from robot.cameras.settings import CameraSourceSettings
from robot.description.spec import RobotSpec


@pytest.fixture
def spec() -> RobotSpec:
    return RobotSpec.load()


def test_a_camera_is_told_with_its_size_rate_and_age(tmp_path: Path, spec: RobotSpec) -> None:
    picture = np.full((spec.lens.height, spec.lens.width), 128, np.uint8)
    for number in range(3):
        cv2.imwrite(str(tmp_path / f"{number}.png"), picture)
    found = list(robot_check.check_camera(spec.lens, CameraSourceSettings(source=str(tmp_path))))
    assert [one.level for one in found] == [OK, OK]
    assert "640 x 480" in found[0].message


def test_pictures_of_another_size_are_a_problem(tmp_path: Path, spec: RobotSpec) -> None:
    cv2.imwrite(str(tmp_path / "0.png"), np.zeros((48, 64), np.uint8))
    (found,) = robot_check.check_camera(spec.lens, CameraSourceSettings(source=str(tmp_path)), 0.1)
    assert (found.level, "640" in found.message) == (PROBLEM, True)


def test_a_camera_that_can_never_be_is_a_problem(spec: RobotSpec) -> None:
    (found,) = robot_check.check_camera(spec.lens, CameraSourceSettings(source="/nowhere/at/all"))
    assert (found.level, "valid are" in found.message) == (PROBLEM, True)


def test_few_or_old_pictures_are_warnings_and_pictures_of_the_future_a_problem(spec) -> None:
    assert robot_check.pictures("the camera", spec.lens, 12, 30).level == WARNING
    assert robot_check.pictures("the camera", spec.lens, 29, 30).level == OK
    levels = [robot_check.age(seconds).level for seconds in (0.05, 0.4, -3)]
    assert levels == [OK, WARNING, PROBLEM]
