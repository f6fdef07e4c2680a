"""The command line of ``brickpose replay``; slow imports happen only when it is used."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from app.interruption import interruptible
from app.options import Commands, add_address, add_own_models
from app.page.access_options import add_access


def add_replay(commands: Commands) -> None:
    """Add the command."""
    command = commands.add_parser(
        "replay",
        help="serve the dashboard on a recording",
        description="Serve the dashboard on a recording. The filter runs again on what was "
        "recorded, with other settings or models if asked, beside what was estimated then. With "
        "--out: write the trajectories as fast as it goes, without a dashboard. Metres, radians, "
        "seconds.",
    )
    command.add_argument("file", type=Path, metavar="FILE", help="an .mcap file, or its folder")
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
    from app.tools.replay.command import run  # noqa: PLC0415

    given: dict[str, Any] = {name: v for name, v in vars(parsed).items() if name != "command"}
    with interruptible():
        return run(given)
