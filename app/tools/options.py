"""The command lines of the tools; slow imports happen only when one is used."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from app.interruption import interruptible
from app.options import (
    Commands,
    add_address,
    add_camera,
    add_config,
    add_map,
    add_own_models,
    add_serial_port,
    config_from,
)
from app.page.access_options import add_access
from app.settings.config import ROBOTS, Config

EMULATED_WORLDS = ("sim", "free")


def add_doctor(commands: Commands) -> None:
    """Add the commands ``doctor`` and ``stop-motors``."""
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
    from robot.hat.serial_port import find_device, stop_motors  # noqa: PLC0415

    stop_motors(vars(parsed).get("serial_port") or find_device())
    return 0


def add_emulate_hat(commands: Commands) -> None:
    """Add the command ``emulate-hat``."""
    command = commands.add_parser(
        "emulate-hat",
        help="a Build HAT without the board, on a serial port of its own",
        description="A Build HAT without the board: prints the name of a serial port, ready to be "
        "opened. Lines on standard input, or through --control, are what a person's hands would "
        "do: help lists them. Ctrl-C ends it.",
    )
    command.add_argument(
        "--link", type=Path, metavar="PATH", help="a symbolic link to the serial port"
    )
    command.add_argument(
        "--pictures",
        type=Path,
        metavar="PATH",
        help="a socket with pictures of the robot's camera, for `run --camera PATH`",
    )
    command.add_argument(
        "--control", type=Path, metavar="PATH", help="a socket that takes lines as typed ones"
    )
    command.add_argument(
        "--world",
        choices=EMULATED_WORLDS,
        help="sim: the robot on a field (pybullet); free: motors that turn freely (default: sim "
        "where pybullet is installed)",
    )
    add_map(command)
    command.add_argument(
        "--seed", type=int, metavar="N", help=f"of everything random (default: {Config().seed})"
    )
    add_config(command)
    command.add_argument(
        "--bootloader",
        action="store_true",
        help="start without firmware, as after switching on (default: it runs already)",
    )
    command.add_argument("--firmware", type=int, metavar="N", help="another version of it runs")
    command.add_argument(
        "--motors",
        metavar="A=KIND,...",
        help="what is plugged in: small, medium, large, medium-grey, large-grey "
        "(default: the robot's motors)",
    )
    command.set_defaults(command=_emulate)


def _emulate(parsed: argparse.Namespace) -> int:
    from app.tools.emulate_hat import emulate_hat  # noqa: PLC0415

    return emulate_hat(vars(parsed))


def add_replay(commands: Commands) -> None:
    """Add the command ``replay``."""
    command = commands.add_parser(
        "replay",
        help="serve the dashboard on a recording",
        description="Serve the dashboard on a recording. The filter runs again on what was "
        "recorded, with other settings or models if asked, beside what was estimated then. With "
        "--out: write the trajectories as fast as it goes, without a dashboard. Metres, radians, "
        "seconds.",
    )
    command.add_argument(
        "file",
        type=Path,
        metavar="FILE",
        help="an .mcap file, its folder, or its name if the page recorded it",
    )
    command.add_argument(
        "--speed",
        type=float,
        help="seconds of the recording in one second, 0.05 to 50 (default: 1)",
    )
    command.add_argument("--paused", action="store_true", help="begin paused at the first tick")
    command.add_argument(
        "--filter-config",
        type=Path,
        metavar="FILE.toml",
        help="settings over those of then: tables localization, scanner, odometry, drive, "
        "start_pose (docs/configuration.md)",
    )
    add_own_models(command)
    command.add_argument(
        "--map",
        metavar="NAME|FILE",
        help="a field of maps/, or an .svg or .yaml file (default: that in the recording)",
    )
    command.add_argument(
        "--profile",
        type=Path,
        metavar="PROFILE.toml",
        help="what `brickpose calibrate` has measured of the robot (default: what was known then)",
    )
    command.add_argument(
        "--seed", type=int, help="seed of the filter (default: that of the recording)"
    )
    add_address(command)
    command.add_argument(
        "--out",
        type=Path,
        metavar="DIR",
        help="write estimated.tum, then.tum, truth.tum and odometry.tum there instead",
    )
    add_access(command)
    command.set_defaults(command=_replay)


def _replay(parsed: argparse.Namespace) -> int:
    from app.tools.replay_command import run  # noqa: PLC0415

    given: dict[str, Any] = {name: v for name, v in vars(parsed).items() if name != "command"}
    with interruptible():
        return run(given)
