"""The command line of ``brickpose record``."""

from __future__ import annotations

import argparse
from pathlib import Path

from app.options import Commands
from robot.settings import SettingError


def add_record(commands: Commands) -> None:
    """Add the command."""
    command = commands.add_parser(
        "record",
        help="record a program that runs, here or on another machine",
        description="Record a running program into a new folder here, until Ctrl-C: MCAP, as "
        "`ros2 bag` has it. Any robot with rosbridge can be recorded.",
        formatter_class=argparse.ArgumentDefaultsHelpFormatter,
    )
    command.add_argument(
        "address",
        nargs="?",
        metavar="HOST[:PORT]",
        default="127.0.0.1:8080",
        help="where the program is",
    )
    command.add_argument(
        "--out", type=Path, metavar="DIR", default=Path(), help="make the new folder in this one"
    )
    command.add_argument(
        "--seconds",
        type=float,
        metavar="S",
        help="how long [s] (default: until Ctrl-C)",
    )
    command.add_argument(
        "--topics",
        nargs="+",
        metavar="NAME",
        help="only these, as scan odom (default: all)",
    )
    command.set_defaults(command=_record)


def _record(parsed: argparse.Namespace) -> int:
    given = vars(parsed)
    seconds = given.get("seconds")
    if seconds is not None and not 0 < seconds < float("inf"):
        raise SettingError(f"--seconds is {seconds:g}; valid is more than 0")
    # Imported here, so that a wrong argument is reported at once.
    from app.recordings.remote import record  # noqa: PLC0415

    record(parsed.address, parsed.out, seconds, given.get("topics", ()))
    return 0
