"""Options of the commands for a Build HAT, and for one that is emulated."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from app.command_parser import CommandParser
from app.options import add_config, add_settings
from app.settings.config import AUTO
from robot.errors import PackageError

EMULATED_WORLDS = ("sim", "free")


def add_stop_motors(command: CommandParser) -> None:
    """Add the options of ``stop-motors``."""
    add_settings(command, "serial_port")
    command.set_defaults(command=_stop)


def _stop(parsed: argparse.Namespace) -> int:
    from robot.hat.serial_port import find_device, stop_motors  # noqa: PLC0415

    port = vars(parsed).get("serial_port", AUTO)
    stop_motors(find_device() if port in ("", AUTO) else port)
    return 0


def add_emulate_hat(command: CommandParser) -> None:
    """Add the options of ``emulate-hat``."""
    command.description = (
        "A Build HAT without the board: prints the name of a serial port, ready to be "
        "opened. Lines on standard input, or through --control, are what a person's hands would "
        "do: help lists them. Ctrl-C ends it."
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
        help="sim: the robot on a field (physics); free: motors that turn freely (default: sim "
        "where a physics engine is installed)",
    )
    add_settings(command, "map", "seed")
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
    if sys.platform == "win32":
        raise PackageError(
            "an emulated Build HAT needs the pseudo-terminals of Linux or macOS, also in WSL; "
            "here --robot kinematic drives without a board"
        )
    from app.features.build_hat.emulate_hat import emulate_hat  # noqa: PLC0415 - its modules are not on Windows

    return emulate_hat(vars(parsed))
