"""Builds the robot ``buildhat``."""

from __future__ import annotations

from typing import TYPE_CHECKING

from app.engine.robot_kind import Blueprint, RobotKind

if TYPE_CHECKING:
    from robot.hat.build_hat import BuildHat


def build(blueprint: Blueprint) -> BuildHat:
    """Open the port and the camera: the motors are under control from then on."""
    from robot.hat.build_hat import BuildHat  # noqa: PLC0415 - other robots have no board

    config = blueprint.config
    return BuildHat.open(blueprint.spec, config.build_hat, config.camera)


BUILD_HAT = RobotKind(
    name="buildhat", about="the real one", build=build, options=("serial_port", "camera")
)
ROBOTS = (BUILD_HAT,)
