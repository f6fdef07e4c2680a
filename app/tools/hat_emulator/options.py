"""The command line of ``brickpose emulate-hat``; slow imports happen only when it is used."""

from __future__ import annotations

import argparse
from pathlib import Path

from app.options import Commands, add_config, add_map
from app.settings.config import Config

WORLDS = ("sim", "free")


def add_emulate_hat(commands: Commands) -> None:
    """Add the command."""
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
        choices=WORLDS,
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
    from app.tools.hat_emulator.command import emulate_hat  # noqa: PLC0415

    return emulate_hat(vars(parsed))
