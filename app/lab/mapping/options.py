"""The command line of ``brickpose map``; slow imports are delayed until they are used."""

from __future__ import annotations

import argparse
from pathlib import Path

from app.interruption import interruptible
from app.options import Commands

OUT = Path("field.svg")


def add_map_command(commands: Commands) -> None:
    """Add the command ``map``."""
    command = commands.add_parser(
        "map",
        help="draw the tape of a floor from a recorded drive",
        description="Draw the tape that a robot saw while it drove, and correct its path. Nothing "
        "has to be known of the floor but the tape's width. Writes a field for `brickpose run "
        "--map`, a ROS map of the same name (.yaml and .pgm) and a report. Metres, radians.",
    )
    command.add_argument("recording", type=Path, metavar="RECORDING", help="a recorded drive")
    command.add_argument(
        "--out",
        type=Path,
        default=OUT,
        metavar="FIELD.svg",
        help="the drawing (default: %(default)s)",
    )
    command.add_argument(
        "--start",
        type=float,
        nargs=3,
        default=(0.0, 0.0, 0.0),
        metavar=("X", "Y", "THETA"),
        help="where the drive begins in the new map (default: 0 0 0)",
    )
    command.add_argument(
        "--width", type=float, default=0.05, metavar="M", help="of the tape (default: %(default)s)"
    )
    command.add_argument(
        "--report",
        type=Path,
        default=None,
        metavar="FILE.html",
        help="the report (default: beside the drawing)",
    )
    command.add_argument(
        "--calibrate",
        type=Path,
        default=None,
        metavar="PROFILE.toml",
        help="calibrate the robot along with the map, from the tape's width alone; writes its "
        "profile",
    )
    command.set_defaults(command=_map)


def _map(parsed: argparse.Namespace) -> int:
    from app.lab.mapping.command import map_recording  # noqa: PLC0415

    with interruptible():
        return map_recording(
            parsed.recording,
            parsed.out,
            parsed.start,
            parsed.width,
            parsed.report,
            parsed.calibrate,
        )
