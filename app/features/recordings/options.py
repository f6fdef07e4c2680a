"""The command lines of ``brickpose record`` and ``brickpose replay``; slow imports are delayed."""

from __future__ import annotations

import argparse
from pathlib import Path

from app.command_parser import NO_OPTIONS, CommandParser
from app.interruption import interruptible
from app.options import add_settings
from app.page.access_options import add_access
from robot.settings import SettingError


def add_record(command: CommandParser) -> None:
    """Add the options of ``record``."""
    command.description = (
        "Record a running program into a new folder here, until Ctrl-C: MCAP, as "
        "`ros2 bag` has it. Any robot with rosbridge can be recorded."
    )
    command.formatter_class = argparse.ArgumentDefaultsHelpFormatter
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
    from app.features.recordings.remote import record  # noqa: PLC0415

    record(parsed.address, parsed.out, seconds, given.get("topics", ()))
    return 0


def add_replay(command: CommandParser) -> None:
    """Add the options of ``replay``."""
    command.description = (
        "Serve the dashboard on a recording. The filter runs again on what was "
        "recorded, with other settings or models if asked, beside what was estimated then. With "
        "--out: write the trajectories as fast as it goes, without a dashboard. Metres, radians, "
        "seconds."
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
    if command.features is not None:
        command.features.add_run_options(command, replays=True)
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
    add_settings(command, "host", "port")
    command.add_argument(
        "--out",
        type=Path,
        metavar="DIR",
        help="write estimated.tum, then.tum, truth.tum and odometry.tum there instead",
    )
    add_access(command)
    command.set_defaults(command=_replay)


def _replay(parsed: argparse.Namespace) -> int:
    from app.features.recordings.replay_command import run  # noqa: PLC0415

    given = {name: value for name, value in vars(parsed).items() if name not in NO_OPTIONS}
    with interruptible():
        return run(given, parsed.features)
