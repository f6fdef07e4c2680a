"""A dark floor with white lines and a dashed yellow one, and pictures of it along a drive."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray
from tape_trials import VIEW

from app.trajectories.trajectory import Trajectory
from app.trajectories.tum_file import write_tum
from robot.fields.field import Field
from robot.fields.svg_field import field_of_drawing
from robot.geometry import Pose2, Twist2
from sim.floor_camera import CameraSettings, FloorCamera

ROAD = """<svg xmlns="http://www.w3.org/2000/svg" width="2000mm" height="2000mm"
 viewBox="-1000 -1000 2000 2000" data-start="0 -600 0">
<rect x="-1000" y="-1000" width="2000" height="2000" fill="#2a2a2c"/><g fill="none">
<path stroke="#f0f0f0" stroke-width="48" d="M-800,800 H400 A400,400 0 0 0 800,400 V-800"/>
<path stroke="#f0f0f0" stroke-width="48" d="M-800,300 H200 L300,200 V-800"/>
<path stroke="#ffd020" stroke-width="24" stroke-dasharray="50 25"
 d="M-800,550 H350 A200,200 0 0 0 550,350 V-800"/></g></svg>"""
TWIST = Twist2(0.2, 0.25)
BEGAN, PERIOD, COUNT = 1_700_000_000.25, 0.125, 24


def road() -> Field:
    return field_of_drawing(ROAD, "road")


@dataclass(frozen=True)
class RoadDrive:
    """Pictures of a drive on the road, in a folder."""

    folder: Path
    field: Path
    odometry: Path
    stamps: list[float]
    truth: list[Pose2]


def drive(folder: Path) -> RoadDrive:
    """Write field, pictures (names tell seconds and nanoseconds) and odometry off by 3 %."""
    pictures = folder / "pictures"
    pictures.mkdir()
    (folder / "road.svg").write_text(ROAD)
    field = road()
    camera = FloorCamera(VIEW, field.floor, CameraSettings(), np.random.default_rng(3))
    stamps = [BEGAN + PERIOD * place for place in range(COUNT)]
    truth = [field.start @ TWIST.integrate(PERIOD * place) for place in range(COUNT)]
    for stamp, pose in zip(stamps, truth, strict=True):
        write(pictures / name(stamp), camera.picture(pose, TWIST))
    wrong = Twist2(1.03 * TWIST.v, 0.98 * TWIST.omega)
    moved = [wrong.integrate(PERIOD * place).to_array() for place in range(COUNT)]
    write_tum(folder / "odometry.tum", Trajectory.of_poses(stamps, moved))
    return RoadDrive(pictures, folder / "road.svg", folder / "odometry.tum", stamps, truth)


def name(stamp: float) -> str:
    """As a robot of ROS 1 names pictures."""
    return f"robot_{math.floor(stamp)}_{round(stamp % 1 * 1e9):09d}.jpg"


def write(path: Path, picture: NDArray[np.uint8]) -> None:
    """Write a picture as a camera does: JPEG, in colour."""
    done, data = cv2.imencode(
        ".jpg", cv2.cvtColor(picture, cv2.COLOR_GRAY2BGR), [cv2.IMWRITE_JPEG_QUALITY, 85]
    )
    assert done
    path.write_bytes(data.tobytes())
