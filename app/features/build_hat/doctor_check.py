"""What ``brickpose doctor`` checks of the real robot, if it is the one that is wanted."""

from __future__ import annotations

import sys
from collections.abc import Iterator

from app.engine.robots import profile_file
from app.features.build_hat import pi_check
from app.features.build_hat.board_check import check_board, firmware_image
from app.features.build_hat.machine import Machine
from app.features.build_hat.robot import BUILD_HAT
from app.features.build_hat.robot_check import check_camera, check_profile
from app.settings.config import Config
from app.tools.doctor.finding import Finding
from robot.description.spec import RobotSpec


def check_robot(config: Config, machine: Machine | None = None) -> Iterator[Finding]:
    """Check the Pi, the board, the motors, the camera and the profile."""
    if config.robot != BUILD_HAT.name:
        return
    machine = machine or Machine()
    yield from pi_check.check_pi(machine)
    yield from pi_check.clock(machine)
    yield firmware_image()
    of_wire = list(pi_check.check_wire(machine, config.build_hat.serial_port))
    yield from of_wire
    spec = RobotSpec.load()
    if pi_check.usable(of_wire):
        device = pi_check.device_of(machine, config.build_hat.serial_port)
        yield from check_board(device, spec.joints, config.build_hat, _tell)
    yield check_profile(profile_file(config), spec)
    yield from check_camera(spec.lens, config.camera)


def _tell(text: str) -> None:
    """Print to standard error what a check waits for, so that the report stays clean."""
    if text:
        sys.stderr.write(f"         ... {text}\n")
        sys.stderr.flush()
