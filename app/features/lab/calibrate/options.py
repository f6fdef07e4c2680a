"""The command line of ``brickpose calibrate``; slow imports are delayed until they are used."""

from __future__ import annotations

import argparse
import math
from pathlib import Path
from typing import Any

from app.command_parser import NO_OPTIONS, CommandParser
from app.condition_option import add_condition
from app.interruption import interruptible
from app.options import add_config, add_settings

Commands = Any
"""What ``add_subparsers`` returns."""


def add_calibrate(command: CommandParser) -> None:
    """Add the options of ``calibrate``."""
    command.description = "Measure how the robot differs from its description."
    kinds = command.add_subparsers(required=True, metavar="{drive,board,lens,mounting,undo}")
    _add_printed_board(kinds)
    _add_lens(kinds)
    _add_mounting(kinds)
    _add_undo(kinds)
    drive = kinds.add_parser(
        "drive",
        help="by driving over a known field",
        description="Let the robot drive turns, arcs and straights near where it stands, or take "
        "a recorded drive, and measure the camera's mounting and focal length, the delay of its "
        "pictures, and the wheels. The robot needs 0.4 m of free floor around it, and tape in "
        "sight. Metres, radians, seconds.",
    )
    drive.add_argument(
        "recording",
        nargs="?",
        type=Path,
        default=None,
        metavar="RECORDING|PICTURES",
        help="a recorded drive, or a folder of pictures, instead of driving now",
    )
    drive.add_argument(
        "--odometry",
        type=Path,
        metavar="FILE.tum",
        help="how the robot moved that took the pictures; --camera is then the file of its camera, "
        "and --out that of the measured one (default: camera.yaml)",
    )
    drive.add_argument(
        "--stamps",
        type=Path,
        metavar="FILE",
        help="stamps and names of the pictures (default: their names are stamps)",
    )
    add_settings(drive, "robot", "map")
    drive.add_argument(
        "--seconds",
        type=float,
        metavar="S",
        help="how long to drive (default: 60, and at most 120 with --until)",
    )
    drive.add_argument(
        "--until",
        type=_millimetres,
        metavar="0.3mm",
        help="drive until the standard deviation of camera_y, which the robot's place depends on "
        "most, is that small",
    )
    drive.add_argument(
        "--start",
        type=float,
        nargs=3,
        metavar=("X", "Y", "THETA"),
        help="where the robot is at the beginning (default: the field's start)",
    )
    add_settings(drive, "seed")
    drive.add_argument(
        "--out",
        type=Path,
        metavar="PROFILE.toml",
        help="the robot's profile; if it exists, its lens is used and kept (default: profile.toml)",
    )
    drive.add_argument(
        "--report", type=Path, metavar="FILE.html", help="the report (default: beside the profile)"
    )
    add_condition(drive)
    add_settings(drive, "serial_port", "camera")
    add_config(drive)
    _add_force(drive)
    drive.set_defaults(command=_drive)


def _millimetres(text: str) -> float:
    """Return a length in metres; ArgumentTypeError if it is none in millimetres, 0.05 to 5."""
    try:
        value = float(text.removesuffix("mm"))
    except ValueError:
        value = math.nan
    if not 0.05 <= value <= 5 or not text.endswith("mm"):
        raise argparse.ArgumentTypeError(f"{text!r}; valid is 0.05mm to 5mm")
    return value / 1e3


def _add_force(command: argparse.ArgumentParser) -> None:
    command.add_argument(
        "--force",
        action="store_true",
        help="write a result that contradicts itself, too, and over files that are there",
    )


def _add_robot(command: argparse.ArgumentParser, about: str) -> None:
    command.add_argument("--robot", metavar="NAME", help=about)


def _drive(parsed: argparse.Namespace) -> int:
    from app.features.lab.calibrate.command import calibrate_drive  # noqa: PLC0415
    from app.features.lab.calibrate.picture_drive import calibrate_pictures  # noqa: PLC0415

    given = _given(parsed)
    with interruptible():
        return calibrate_pictures(given) if "odometry" in given else calibrate_drive(given)


def _add_printed_board(kinds: Commands) -> None:
    board = kinds.add_parser(
        "board",
        help="a board to print, for lens and mounting",
        description="Write a page with a chessboard or ChArUco board at its true size, and rulers "
        "to check the printer by.",
    )
    add_board(board, seen=False)
    board.add_argument("--paper", metavar="NAME", help="a4, a3 or letter (default: a4)")
    board.add_argument(
        "--out", type=Path, metavar="FILE.pdf|FILE.svg", help="the page (default: board.pdf)"
    )
    board.add_argument("--force", action="store_true", help="write over a file that is there")
    board.set_defaults(command=_board)


def _add_lens(kinds: Commands) -> None:
    lens = kinds.add_parser(
        "lens",
        help="the lens, by pictures of a printed board",
        description="Measure the lens by pictures of a printed chessboard or ChArUco board, from "
        "many sides, in all parts of the picture. Pictures that are of no use are refused with the "
        "reason. Writes a ROS camera_info file, or another (--format).",
    )
    lens.add_argument(
        "pictures", nargs="+", type=Path, metavar="PICTURES", help="folders, or files"
    )
    add_board(lens)
    lens.add_argument(
        "--out",
        type=Path,
        metavar="CAMERA.yaml|PROFILE.toml",
        help="the lens: ROS's camera_info, or in the robot's profile (default: camera.yaml)",
    )
    lens.add_argument(
        "--format",
        choices=("ros", "opencv", "kalibr", "ini"),
        help="what program the file is for: ROS's camera_info, OpenCV's FileStorage, Kalibr's "
        "camchain, ROS's old .ini (default: ros)",
    )
    lens.add_argument(
        "--report", type=Path, metavar="FILE.html", help="the report (default: beside the lens)"
    )
    _add_robot(lens, "whose profile it is (default: the program's own robot)")
    _add_force(lens)
    lens.set_defaults(command=_lens)


def _add_mounting(kinds: Commands) -> None:
    mounting = kinds.add_parser(
        "mounting",
        help="how the camera is mounted, by one picture of the floor",
        description="Measure roll, pitch, yaw, height and place of the camera, by one picture of a "
        "printed board that lies on the floor, or of the tape of a known field. Writes them into "
        "the robot's profile; its other values are kept. Metres, radians.",
    )
    mounting.add_argument("picture", type=Path, metavar="PICTURE", help="taken by the robot")
    add_board(mounting)
    mounting.add_argument(
        "--at",
        type=float,
        nargs=3,
        metavar=("X", "Y", "THETA"),
        help="where the board lies: its lower right corner seen from the robot's axle, and where "
        "the top of its page points (0: ahead)",
    )
    mounting.add_argument(
        "--map",
        metavar="NAME|FILE",
        help="instead of a board, the tape of this field: best a corner of it",
    )
    mounting.add_argument(
        "--start",
        type=float,
        nargs=3,
        metavar=("X", "Y", "THETA"),
        help="where the robot stands on that field (default: the field's start)",
    )
    mounting.add_argument(
        "--camera",
        type=Path,
        metavar="CAMERA.yaml",
        help="the lens (default: that of the profile, else the described one)",
    )
    mounting.add_argument(
        "--camera-name",
        metavar="NAME",
        help="which camera of a file of several, by name or topic (Kalibr, DepthAI, COLMAP)",
    )
    mounting.add_argument(
        "--out",
        type=Path,
        metavar="PROFILE.toml",
        help="the robot's profile, which may exist (default: profile.toml)",
    )
    mounting.add_argument(
        "--report",
        type=Path,
        metavar="FILE.png",
        help="the picture with the floor's grid (default: beside the profile)",
    )
    _add_robot(mounting, "whose camera it is (default: that of the program's own robot)")
    _add_force(mounting)
    mounting.set_defaults(command=_mounting)


def _add_undo(kinds: Commands) -> None:
    undo = kinds.add_parser(
        "undo",
        help="go back to the profile before",
        description="Go back to the profile before the last calibration. The two change places, so "
        "a second undo takes the first one back.",
    )
    undo.add_argument(
        "profile",
        nargs="?",
        type=Path,
        default=None,
        metavar="PROFILE.toml",
        help="the profile (default: the real robot's own)",
    )
    _add_robot(undo, "whose own profile (default: that of buildhat)")
    undo.set_defaults(command=_undo)


def add_board(command: argparse.ArgumentParser, *, seen: bool = True) -> None:
    """Add the options that say which board it is: one that is seen, or one to be printed."""
    corners = "; of a chessboard its inner corners will do, as ROS counts them" if seen else ""
    command.add_argument(
        "--type",
        choices=("chessboard", "charuco", *(("aprilgrid",) if seen else ())),
        help="kind of board (default: chessboard)",
    )
    command.add_argument(
        "--squares",
        metavar="CxR",
        help=f"its squares, or tags, across and up{corners} (default: 10x7)",
    )
    command.add_argument(
        "--size", type=float, metavar="M", help="side of a square, or of a tag [m] (default: 0.025)"
    )
    command.add_argument(
        "--marker", type=float, metavar="SHARE", help="markers by squares (charuco; default: 0.7)"
    )
    command.add_argument(
        "--dictionary",
        metavar="NAME",
        help="which markers (charuco; default: 5x5_250; aprilgrid: apriltag_36h11)",
    )
    if seen:
        command.add_argument(
            "--spacing",
            type=float,
            metavar="SHARE",
            help="gaps between tags by their sides, Kalibr's tagSpacing (aprilgrid; default: 0.3)",
        )


def _lens(parsed: argparse.Namespace) -> int:
    from app.features.lab.calibrate.lens_command import calibrate_lens_command  # noqa: PLC0415

    return calibrate_lens_command(_given(parsed))


def _board(parsed: argparse.Namespace) -> int:
    from app.features.lab.calibrate.board_command import print_board  # noqa: PLC0415

    return print_board(_given(parsed))


def _mounting(parsed: argparse.Namespace) -> int:
    from app.features.lab.calibrate.mounting_command import calibrate_mounting  # noqa: PLC0415

    return calibrate_mounting(_given(parsed))


def _undo(parsed: argparse.Namespace) -> int:
    from app.features.lab.calibrate.undo_command import undo_calibration  # noqa: PLC0415

    return undo_calibration(parsed.profile, vars(parsed).get("robot"))


def _given(parsed: argparse.Namespace) -> dict[str, Any]:
    return {name: value for name, value in vars(parsed).items() if name not in NO_OPTIONS}
