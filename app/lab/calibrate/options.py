"""The command line of ``brickpose calibrate``; slow imports are delayed until they are used."""

from __future__ import annotations

import argparse
from pathlib import Path

from app.interruption import interruptible
from app.options import Commands, add_camera, add_condition, add_config, add_map, add_serial_port
from app.settings.config import ROBOTS


def add_calibrate(commands: Commands) -> None:
    """Add the command ``calibrate``."""
    command = commands.add_parser(
        "calibrate",
        help="measure the robot that was built",
        description="Measure how the robot differs from its description.",
        allow_abbrev=False,
    )
    kinds = command.add_subparsers(required=True, metavar="{drive}")
    drive = kinds.add_parser(
        "drive",
        help="by driving over a known field",
        description="Let the robot drive turns, arcs and straights near where it stands, or take "
        "a recorded drive, and measure the camera's mounting and focal length, the delay of its "
        "pictures, and the wheels. The robot needs 0.4 m of free floor around it, and tape in "
        "sight. Metres, radians, seconds.",
        argument_default=argparse.SUPPRESS,
        allow_abbrev=False,
    )
    drive.add_argument(
        "recording",
        nargs="?",
        type=Path,
        default=None,
        metavar="RECORDING",
        help="a recorded drive, instead of driving now",
    )
    drive.add_argument("--robot", choices=ROBOTS, help="which robot drives (default: sim)")
    add_map(drive)
    drive.add_argument("--seconds", type=float, metavar="S", help="how long to drive (default: 60)")
    drive.add_argument(
        "--start",
        type=float,
        nargs=3,
        metavar=("X", "Y", "THETA"),
        help="where the robot is at the beginning (default: the field's start)",
    )
    drive.add_argument("--seed", type=int, metavar="N", help="which simulated robot (default: 0)")
    drive.add_argument(
        "--out",
        type=Path,
        metavar="PROFILE.toml",
        help="the robot's profile (default: profile.toml)",
    )
    add_condition(drive)
    add_serial_port(drive)
    add_camera(drive)
    add_config(drive)
    drive.set_defaults(command=_drive)


def _drive(parsed: argparse.Namespace) -> int:
    from app.lab.calibrate.command import calibrate_drive  # noqa: PLC0415

    given = {name: value for name, value in vars(parsed).items() if name != "command"}
    with interruptible():
        return calibrate_drive(given)
