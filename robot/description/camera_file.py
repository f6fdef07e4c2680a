"""A camera that is not the described robot's: its lens, and where it is mounted."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from robot.camera import CameraError
from robot.description.spec import RobotSpec
from robot.geometry import Array
from robot.lens_files.reading import LensFile

BODY_FROM_OPTICAL = np.array([[0.0, 0, 1], [-1, 0, 0], [0, -1, 0]])
"""Axes of a camera that looks ahead: z ahead, x to the right, y down."""
HIGHEST_M = 5.0
"""Largest distance of a camera from the robot's origin [m]."""
LONGEST_DELAY = 1.0
"""Largest delay of a picture [s]."""


def with_camera(spec: RobotSpec, file: LensFile) -> RobotSpec:
    """Return a robot with the camera of a file.

    The file has the lens. Two keys are BrickPose's, and other programs ignore them: ``mounting``
    with ``xyz`` [m] and ``rpy`` [rad], the camera's pose on the robot as a URDF has it, for a
    camera that looks ahead where all angles are zero; and ``picture_delay`` [s], how much later
    than its exposure a picture is stamped. What is missing stays as it is in the description.

    Raises:
        CameraError: a value is invalid; the message names it.
    """
    content = file.keys
    try:
        pose, delay = spec.robot_from_camera, spec.picture_delay
        if "mounting" in content:
            pose = _pose(content["mounting"])
        if "picture_delay" in content:
            delay = _number(content["picture_delay"], "picture_delay", -LONGEST_DELAY, "s")
    except CameraError as error:
        raise CameraError(f"{file.path}: {error}") from error
    return replace(spec, lens=file.lens, robot_from_camera=pose, picture_delay=delay)


def mounting_pose(xyz: Array, rpy: Array) -> Array:
    """Return the transform (4, 4) from the optical frame to the robot frame.

    Args:
        xyz: (3,) place [m].
        rpy: (3,) roll, pitch and yaw [rad] about fixed axes, x first; pitch above zero looks down.
    """
    pose = np.eye(4)
    pose[:3, :3] = Rotation.from_euler("xyz", rpy).as_matrix() @ BODY_FROM_OPTICAL
    pose[:3, 3] = xyz
    return pose


def _pose(mounting: Any) -> Array:
    if not isinstance(mounting, dict) or set(mounting) != {"xyz", "rpy"}:
        raise CameraError("mounting needs xyz: [x, y, z] in m and rpy: [roll, pitch, yaw] in rad")
    pose = mounting_pose(
        _numbers(mounting["xyz"], "mounting.xyz", HIGHEST_M, "m"),
        _numbers(mounting["rpy"], "mounting.rpy", math.pi, "rad"),
    )
    if pose[2, 3] <= 0:
        raise CameraError(f"the camera is {pose[2, 3]:g} m high; it must be above 0")
    if pose[2, 2] >= 0:
        raise CameraError("the camera looks up or level; its pitch must be above 0")
    return pose


def _numbers(values: Any, name: str, most: float, unit: str) -> Array:
    if not isinstance(values, list) or len(values) != 3:
        raise CameraError(f"{name} needs a list of three numbers")
    return np.array([_number(value, name, -most, unit) for value in values])


def _number(text: Any, name: str, low: float, unit: str) -> float:
    try:
        value = float(text) if isinstance(text, str) else math.nan
    except ValueError:
        value = math.nan
    if not low <= value <= -low:
        shown = repr(text)[:40] if isinstance(text, str) else type(text).__name__
        raise CameraError(f"{name} has {shown}; valid is {low:g} to {-low:g} {unit}")
    return value
