"""Options of the tools on the command line; slow imports happen only when one is used."""

from __future__ import annotations

import argparse

from app.command_parser import CommandParser
from app.interruption import interruptible
from app.options import add_config, add_settings, config_from


def add_doctor(command: CommandParser) -> None:
    """Add the options of ``doctor``."""
    command.description = (
        "Check this machine; with --robot buildhat the robot too: serial port, Build "
        "HAT, motors, camera. Nothing turns. Each line is ok, a warning or a problem with its "
        "cure; ends with 1 if there is a problem."
    )
    add_settings(command, "robot", "serial_port", "camera")
    add_config(command)
    command.set_defaults(command=_doctor)


def _doctor(parsed: argparse.Namespace) -> int:
    from app.tools.doctor.command import doctor  # noqa: PLC0415

    config = config_from(parsed)
    with interruptible():  # a check runs a file in a folder that has to go again
        return doctor(config, parsed.features)
