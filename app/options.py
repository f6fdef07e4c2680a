"""Options that several commands have."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from app.conditions import condition_names
from app.config import Config

Commands = Any
"""What ``add_subparsers`` returns."""


def add_map(command: argparse.ArgumentParser) -> None:
    """Which field."""
    command.add_argument(
        "--map",
        metavar="NAME|FILE",
        default=argparse.SUPPRESS,
        help="a field of maps/, generated-N (from a seed), or an .svg or .yaml file "
        f"(default: {Config().map})",
    )


def add_condition(command: argparse.ArgumentParser, *, many: bool = False) -> None:
    """What is worse than usual with a simulated robot."""
    again = "; may be given more than once" if many else ""
    command.add_argument(
        "--condition",
        metavar="NAME",
        action="append" if many else "store",
        default=argparse.SUPPRESS,
        help=f"what is worse than usual in a simulation{again}: {condition_names()} "
        "(default: default)",
    )


def add_config(command: argparse.ArgumentParser) -> None:
    """Settings from a file."""
    command.add_argument(
        "--config",
        type=Path,
        metavar="FILE.toml",
        default=argparse.SUPPRESS,
        help="settings (docs/configuration.md); options win over them",
    )


def add_serial_port(command: argparse.ArgumentParser) -> None:
    """Where the Build HAT is."""
    command.add_argument(
        "--serial-port",
        metavar="DEVICE",
        default=argparse.SUPPRESS,
        help="the Build HAT's serial port (default: that of this Pi)",
    )


def add_camera(command: argparse.ArgumentParser) -> None:
    """What the real robot sees with."""
    command.add_argument(
        "--camera",
        metavar="SOURCE",
        dest="camera_source",
        default=argparse.SUPPRESS,
        help="the real robot's camera: pi, /dev/video0, a folder of pictures, a video file "
        "(default: the first that delivers pictures)",
    )
