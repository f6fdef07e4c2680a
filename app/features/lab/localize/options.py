"""The command line of ``brickpose localize``; slow imports are delayed until they are used."""

from __future__ import annotations

import argparse
from pathlib import Path

from app.command_parser import CommandParser
from app.interruption import interruptible

EXAMPLE = """\
Without --initial-pose the robot may be anywhere on the map's free floor.

  brickpose localize office.bag --map office.yaml
  brickpose localize run_7/ --map office.yaml --initial-pose 3.2 -1.0 1.57 --out run_7_localized

A folder of pictures with stamps, on a taped field (docs/pictures.md):

  brickpose localize pictures/ --map town.svg --camera camera.yaml --odometry odometry.tum

"""


def add_localize(command: CommandParser) -> None:
    """Add the options of ``localize``."""
    command.description = (
        "Follow a robot with a laser through its bag, by LaserScan and Odometry (or "
        "tf), on a map of map_server. Writes its way as a TUM file, a picture and results.json."
    )
    command.epilog = EXAMPLE
    command.formatter_class = _WithSettings
    command.argument_default = None
    command.add_argument(
        "bag", type=Path, metavar="BAG|PICTURES/",
        help="a .bag, .mcap or .db3 file, a ROS 2 bag's folder, or a folder of pictures",
    )  # fmt: skip
    command.add_argument(
        "--map", type=Path, metavar="MAP.yaml|FIELD.svg", required=True,
        help="a map of map_server; for pictures a field",
    )  # fmt: skip
    command.add_argument(
        "--out", type=Path, metavar="DIR|FILE",
        help="where the results go: a folder for a bag, a .tum file for pictures (default: "
        "localized/ and the recording's name)",
    )  # fmt: skip
    command.add_argument(
        "--force", action="store_true",
        help="write over files that are there, and are no results of this command",
    )  # fmt: skip
    add_topics(command)
    _add_start(command)
    _add_pictures(command)
    command.add_argument(
        "--filter-config", type=Path, metavar="FILE.toml",
        help="settings over those below",
    )  # fmt: skip
    command.add_argument(
        "--seed", type=int, default=0, help="seed of everything random (default: 0)"
    )
    command.set_defaults(command=_localize)


def add_topics(command: argparse.ArgumentParser) -> None:
    """Add the options that say what is read of a laser's bag."""
    command.add_argument(
        "--scan-topic", action="append", metavar="NAME",
        help="which LaserScan (default: the only one); once for each laser, if a robot has several",
    )  # fmt: skip
    command.add_argument(
        "--odom-topic", metavar="NAME",
        help="which Odometry (default: the only one, or /odom; without any, tf odom to base)",
    )  # fmt: skip
    command.add_argument(
        "--odom-frame", metavar="NAME",
        help="take odometry from tf, in this frame (default: odom, if there is no Odometry)",
    )  # fmt: skip
    command.add_argument(
        "--base-frame", metavar="NAME",
        help="the robot's frame (default: that of the Odometry, or the child of odom)",
    )  # fmt: skip
    command.add_argument(
        "--namespace", metavar="NAME",
        help="of several robots the one whose topics and frames begin so",
    )  # fmt: skip
    command.add_argument(
        "--laser-pose", type=float, nargs=3, action="append", metavar=("X", "Y", "THETA"),
        help="where the laser sits on the robot [m, m, rad] (default: as the bag's transforms say, "
        "else 0 0 0); of several once for each, in the order of --scan-topic",
    )  # fmt: skip
    command.add_argument(
        "--clock", default="header",
        help="stamps: header, or log for when messages were recorded, if the robot's computers had "
        "different clocks (default: header)",
    )  # fmt: skip


def _add_pictures(command: argparse.ArgumentParser) -> None:
    group = command.add_argument_group("of a folder of pictures")
    for name, metavar, words in (
        ("camera", "CAMERA.yaml", "the camera's lens and mounting (default: the robot's own)"),
        (
            "profile",
            "PROFILE.toml",
            "what `brickpose calibrate` has measured (none: nothing)",
        ),
        ("odometry", "FILE.tum", "its motion (default: each step is like the one before)"),
        ("stamps", "FILE", "a list of stamps and file names (default: stamps in the names)"),
        ("overlays", "DIR", "write each picture with the edges that were found"),
        ("config", "FILE.toml", "settings of scanner and filter (docs/configuration.md)"),
    ):
        group.add_argument(f"--{name}", type=Path, metavar=metavar, help=words)
    group.add_argument(
        "--camera-name", metavar="NAME",
        help="which camera of a file of several, by name or topic (Kalibr, DepthAI, COLMAP)",
    )  # fmt: skip


def _add_start(command: argparse.ArgumentParser) -> None:
    command.add_argument(
        "--initial-pose", type=float, nargs=3, metavar=("X", "Y", "THETA"),
        help="where the robot is at the first scan [m, m, rad in the map] (default: anywhere)",
    )  # fmt: skip
    command.add_argument(
        "--sd-xy", type=float, metavar="M", help="how well its place is known [m] (default: 0.5)"
    )
    command.add_argument(
        "--sd-theta", type=float, metavar="RAD",
        help="how well its heading is known [rad] (default: 0.25)",
    )  # fmt: skip


class _WithSettings(argparse.RawDescriptionHelpFormatter):
    """Shows the settings in the help, but not in the usage that follows an error."""

    _whole = False

    def start_section(self, heading: str | None) -> None:
        self._whole = True
        super().start_section(heading)

    def format_help(self) -> str:
        if not self._whole:
            return super().format_help()
        from app.features.lab.localize.settings import shown_defaults  # noqa: PLC0415

        return super().format_help() + shown_defaults() + "\n"


def _localize(parsed: argparse.Namespace) -> int:
    from app.features.lab.localize.command import localize_command  # noqa: PLC0415

    with interruptible():
        return localize_command(parsed)
