"""The command line of ``brickpose run``; slow imports are delayed until they are used."""

from __future__ import annotations

import argparse

from app.command_parser import CommandParser
from app.options import add_config, add_settings, config_from
from app.page.access_options import add_access


def add_run(run: CommandParser) -> None:
    """Add the options of ``run``."""
    run.description = "Serve the dashboard with one robot. Ctrl-C stops the motors and ends."
    run.formatter_class = argparse.ArgumentDefaultsHelpFormatter
    add_serving(run)
    run.set_defaults(command=_run)


def add_serving(run: CommandParser) -> None:
    """Add the options of every command that serves the dashboard with a robot."""
    add_settings(run, "robot", "serial_port", "camera", "map", "host", "port", "seed")
    add_access(run)
    add_settings(run, "profile")
    add_config(run)
    if run.features is not None:
        run.features.add_run_options(run)


def _run(parsed: argparse.Namespace) -> int:
    config = config_from(parsed)
    # Imported here, so that a wrong argument is refused at once.
    from app.page.run_command import run_dashboard  # noqa: PLC0415

    return run_dashboard(parsed, config, parsed.features)
