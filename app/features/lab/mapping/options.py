"""The command line of ``brickpose map``; slow imports are delayed until they are used."""

from __future__ import annotations

import argparse
from pathlib import Path

from app.command_parser import CommandParser
from app.features.lab.localize.options import add_topics
from app.interruption import interruptible
from robot.scanning.tape import BRIGHTNESS

METHODS = ("strokes", "graph", "grid")


def add_map_command(command: CommandParser) -> None:
    """Add the options of ``map``."""
    command.description = (
        "Draw the tape that a robot saw while it drove, and correct its path. Nothing "
        "has to be known of the floor but the tape's width. Writes a field for `brickpose run "
        "--map`, a ROS map of the same name (.yaml and .pgm) and a report. Of the bag of a robot "
        "with a laser, or with --method grid, it writes a ROS map and the robot's path (.tum). "
        "Metres, radians."
    )
    command.argument_default = None
    command.add_argument(
        "recording",
        type=Path,
        metavar="RECORDING|BAG",
        help="a recorded drive; or a laser's .bag, .mcap, .db3, ROS 2 bag folder or CARMEN .log",
    )
    command.add_argument(
        "--out",
        type=Path,
        default=None,
        metavar="FIELD.svg|MAP.yaml",
        help="the drawing, or the ROS map (default: field.svg, or field.yaml)",
    )
    command.add_argument(
        "--force",
        action="store_true",
        default=False,
        help="overwrite an earlier map and its report; write a map that contradicts itself",
    )
    command.add_argument(
        "--method",
        choices=METHODS,
        default=None,
        help="strokes: tape as lines, adjusted as a whole; graph: walls by a pose graph over "
        "matched scans, for a laser; grid: an occupancy grid by particles (FastSLAM, for teaching; "
        "default: strokes, and graph for a laser)",
    )
    command.add_argument(
        "--seed", type=int, default=0, help="of the particles (default: %(default)s)"
    )
    add_topics(command)
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
        "--brightness",
        choices=[choice for choice in BRIGHTNESS if choice != "field"],
        default=None,
        help="of the tape, beside the floor's (default: as the recording's scanner is set, or what "
        "the pictures show)",
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
    from app.features.lab.mapping.command import map_recording  # noqa: PLC0415
    from app.features.lab.mapping.grid_command import map_in_cells  # noqa: PLC0415
    from app.features.lab.mapping.looks import is_laser_bag  # noqa: PLC0415
    from robot.settings import SettingError  # noqa: PLC0415

    with interruptible():
        laser = is_laser_bag(parsed.recording)
        method = parsed.method or ("graph" if laser else "strokes")
        if method == ("strokes" if laser else "graph"):
            needed = "pictures of tape" if laser else "the scans of a laser"
            valid = "graph, grid" if laser else "strokes, grid"
            raise SettingError(f"--method {method} needs {needed}; valid here are {valid}")
        if parsed.out is None:
            parsed.out = Path("field.svg" if method == "strokes" else "field.yaml")
        if method != "strokes":
            return map_in_cells(parsed, method, laser=laser)
        return map_recording(
            parsed.recording,
            parsed.out,
            parsed.start,
            parsed.width,
            parsed.report,
            parsed.calibrate,
            force=parsed.force,
            brightness=parsed.brightness,
        )
