"""Runs ``brickpose export ros2``."""

from __future__ import annotations

import argparse

from app.console import say
from app.options import config_of
from app.ros2.export.export import MOCK, export_ros2


def export_command(parsed: argparse.Namespace) -> int:
    """Write the files, and print their paths."""
    given = vars(parsed)
    for path in export_ros2(parsed.folder, config_of(given), given.get("hardware_plugin", MOCK)):
        say(str(path))
    return 0
