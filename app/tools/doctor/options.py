"""The command line of ``brickpose doctor`` and ``brickpose stop-motors``."""

from __future__ import annotations

import argparse

from app.options import Commands, add_camera, add_config, add_serial_port, config_from
from app.settings.config import ROBOTS


def add_doctor(commands: Commands) -> None:
    """Add both commands."""
    command = commands.add_parser(
        "doctor",
        help="check this machine, or a real robot, and say what to do",
        description="Check this machine; with --robot buildhat the robot too: serial port, Build "
        "HAT, motors, camera. Nothing turns. Each line is ok, a warning or a problem with its "
        "cure; ends with 1 if there is a problem.",
    )
    command.add_argument("--robot", choices=ROBOTS, help="which robot is to work here")
    add_serial_port(command)
    add_camera(command)
    add_config(command)
    command.set_defaults(command=_doctor)
    stop = commands.add_parser(
        "stop-motors",
        help="stop the motors of a Build HAT that no program drives any more",
    )
    add_serial_port(stop)
    stop.set_defaults(command=_stop)


def _doctor(parsed: argparse.Namespace) -> int:
    from app.tools.doctor.command import doctor  # noqa: PLC0415

    return doctor(config_from(parsed))


def _stop(parsed: argparse.Namespace) -> int:
    from robot.hat.serial_port import find_device  # noqa: PLC0415
    from robot.hat.stop import stop_motors  # noqa: PLC0415

    stop_motors(vars(parsed).get("serial_port") or find_device())
    return 0
