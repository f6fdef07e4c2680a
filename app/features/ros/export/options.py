"""The command line of ``brickpose export``."""

from __future__ import annotations

import argparse
from pathlib import Path

from app.command_parser import CommandParser
from app.interruption import interruptible
from app.options import add_config, add_settings


def add_export(export: CommandParser) -> None:
    """Add the options of ``export``."""
    export.description = "Write files for other programs."
    kinds = export.add_subparsers(required=True, metavar="KIND")
    ros2 = kinds.add_parser(
        "ros2",
        help="URDF with ros2_control, parameters of controllers and nav2, map",
        description="Write URDF, parameters and map for ROS 2; the numbers are this robot's.",
    )
    ros2.add_argument("folder", type=Path, metavar="DIR", help="where to; made if it is not there")
    add_settings(ros2, "map", "profile")
    add_config(ros2)
    ros2.add_argument(
        "--hardware-plugin",
        metavar="NAME",
        help="ros2_control's hardware for the wheels (default: its mock_components/GenericSystem)",
    )
    ros2.set_defaults(command=_export)


def _export(parsed: argparse.Namespace) -> int:
    from app.features.ros.export.export import export_command  # noqa: PLC0415

    with interruptible():
        return export_command(parsed)
