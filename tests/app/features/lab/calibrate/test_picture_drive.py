"""A camera is measured by a folder of its pictures and the robot's odometry, and written."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
import pytest
from calibrations import SPEC, SQUARE

from app.command_line import main
from app.features.lab.calibrate.picture_drive import wheel_angles
from app.trajectories.trajectory import Trajectory
from app.trajectories.tum_file import write_tum
from robot.calibration.programme import velocity
from robot.description.camera_file import with_camera
from robot.description.unknowns import Differences
from robot.driving.differential_drive import DifferentialDrive
from robot.geometry import Array, Pose2, Twist2
from robot.lens_files.reading import read_lens_file
from sim.floor_camera import CameraSettings, FloorCamera

PERIOD, COUNT, STEPS = 0.125, 200, 5
"""Of the pictures [s]; odometry is so many times as frequent."""
ASKEW = {"camera_roll": 0.02, "camera_pitch": -0.03, "camera_z": 0.004, "picture_delay": 0.03}
BUILT = Differences().changed(ASKEW).applied_to(SPEC)


@dataclass(frozen=True)
class Drive:
    folder: Path
    odometry: Path


@pytest.fixture(scope="module")
def drive(tmp_path_factory: pytest.TempPathFactory) -> Drive:
    """Pictures of a camera that is askew and late, and odometry that is 2 % too long."""
    root = tmp_path_factory.mktemp("drive")
    folder = root / "pictures"
    folder.mkdir()
    camera = FloorCamera(BUILT.floor_view, SQUARE.floor, CameraSettings(), np.random.default_rng(5))
    pose, odometry, poses = SQUARE.start, Pose2(), []
    tick = PERIOD / STEPS
    for step in range(STEPS * COUNT):
        stamp, twist = step * tick, velocity(step * tick)
        poses.append([stamp, *odometry.to_array()])
        if step % STEPS == 0:
            picture = camera.picture(pose, twist)
            cv2.imwrite(str(folder / f"{stamp + BUILT.picture_delay:.4f}.png"), picture)
        pose = pose @ twist.integrate(tick)
        odometry = odometry @ Twist2(1.02 * twist.v, twist.omega).integrate(tick)
    (folder / "0.0010.png").write_bytes(b"no picture")
    table = np.array(poses)
    write_tum(root / "odometry.tum", Trajectory.of_poses(table[:, 0], table[:, 1:]))
    return Drive(folder, root / "odometry.tum")


def calibrated(drive: Drive, out: Path, *more: str) -> int:
    given = ["calibrate", "drive", drive.folder, "--odometry", drive.odometry, "--map", "square"]
    return main([str(part) for part in [*given, "--out", out, *more]])


@pytest.mark.slow
def test_pictures_and_odometry_tell_how_a_camera_is_mounted(
    drive: Drive, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "camera.yaml"
    assert calibrated(drive, out) == 0
    told = capsys.readouterr().out
    assert "0.0010.png is left out: it is no picture that can be read" in told
    assert out.with_suffix(".html").is_file()
    measured = with_camera(SPEC, read_lens_file(out))
    found = Differences.between(BUILT, measured, measured.picture_delay - BUILT.picture_delay)
    roll, pitch, yaw, x, y, z, focal, delay, *_ = found.values.tolist()
    assert max(map(abs, (roll, pitch, yaw))) < math.radians(0.15)
    assert max(map(abs, (x, y, z))) < 0.0015
    assert abs(focal) < 0.01
    assert abs(delay) < 0.006


def test_wheels_turn_as_a_robot_that_moves_like_that() -> None:
    kinematics = DifferentialDrive(SPEC)
    twists = [Twist2(0.2, 0.0), Twist2(0.1, 1.3), Twist2(-0.1, 0.4), Twist2(0.0, -2.0)]
    pose, poses = Pose2(1.0, -2.0, 3.0), [Pose2(1.0, -2.0, 3.0).to_array()]
    rolled: list[Array] = [np.zeros(2)]
    for twist in twists:
        pose = pose @ twist.integrate(0.5)
        poses.append(pose.to_array())
        wheels = kinematics.wheels(twist)[[kinematics.left, kinematics.right]]
        rolled.append(rolled[-1] + 0.5 * wheels)
    np.testing.assert_allclose(wheel_angles(np.array(poses), kinematics), rolled, atol=1e-9)


@pytest.mark.parametrize(
    ("more", "words"),
    [
        (["--out", "camera.toml"], "valid is a file that ends in .yaml"),
        (["--until", "0.3mm"], "--until has no effect with a folder of pictures"),
        (["--seconds", "1"], "valid is 5 to 600"),
    ],
)
def test_what_pictures_cannot_use_is_refused(
    more: list[str], words: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    nothing = Drive(tmp_path, tmp_path / "odometry.tum")
    assert calibrated(nothing, tmp_path / "camera.yaml", *more) == 2
    assert words in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_odometry_alone_is_no_drive(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["calibrate", "drive", "--odometry", "way.tum"]) == 2
    assert "valid is drive PICTURES" in capsys.readouterr().err
