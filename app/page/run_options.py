"""The command line of ``brickpose run``; slow imports are delayed until they are used."""

from __future__ import annotations

import argparse

from app.command_parser import CommandParser
from app.options import (
    add_address,
    add_camera,
    add_condition,
    add_config,
    add_map,
    add_profile,
    add_serial_port,
    config_from,
)
from app.page.access_options import add_access
from app.settings.config import Config


def add_run(run: CommandParser) -> None:
    """Add the options of ``run``."""
    run.description = "Serve the dashboard with one robot. Ctrl-C stops the motors and ends."
    run.formatter_class = argparse.ArgumentDefaultsHelpFormatter
    add_serving(run)
    run.set_defaults(command=_run)


def add_serving(run: CommandParser) -> None:
    """Add the options of every command that serves the dashboard with a robot."""
    default = Config()
    run.add_argument(
        "--robot",
        metavar="NAME",
        help="sim: with physics; kinematic: without, its wheels roll as if on rails; buildhat: the "
        "real one; brickpose doctor lists those of other packages, too (default: sim where a "
        "physics engine is installed)",
    )
    add_serial_port(run)
    add_camera(run)
    add_map(run)
    add_address(run)
    run.add_argument(
        "--seed",
        type=int,
        help=f"seed of everything random (default: {default.seed})",
    )
    add_access(run)
    add_condition(run)
    add_profile(run)
    add_config(run)
    _add_start_pose(run)
    if run.features is not None:
        run.features.add_run_options(run)


def _add_start_pose(run: argparse.ArgumentParser) -> None:
    run.add_argument(
        "--restore-pose",
        action="store_true",
        help="start where the last run on the same map ended",
    )
    run.add_argument(
        "--pose-file",
        metavar="FILE",
        help="where the pose is saved (default: a file a robot and map in the user's state folder)",
    )


def _run(parsed: argparse.Namespace) -> int:
    config = config_from(parsed)
    # Imported here, so that a wrong argument is refused at once.
    from app.page.run_command import run_dashboard  # noqa: PLC0415

    return run_dashboard(parsed, config, parsed.features)
