"""BrickPose's public front: what programs, notebooks and packages of others build on.

A name is imported when it is first asked for: ``import brickpose`` costs next to nothing, and a
program pays for what it uses. What is not in ``__all__`` may change. Lengths are in metres, angles
in radians, stamps in seconds of the robot's clock; poses are in the map unless a name says
otherwise. ``examples/`` has a script for each use.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from app.engine.build import build_program
    from app.engine.engine import Engine
    from app.engine.program import Program
    from app.engine.snapshot import Snapshot
    from app.feature import Feature
    from app.messages.commands import (
        PlaceCommand,
        ScatterCommand,
        SetParametersCommand,
        SetPoseCommand,
    )
    from app.messages.driving_commands import DriveCommand, FigureEightCommand, StopCommand
    from app.page.notebook import view
    from app.settings.config import MAPS, Config, load_config
    from robot.description.spec import RobotSpec
    from robot.errors import BrickPoseError
    from robot.fields.field import Field
    from robot.fields.field_loading import load_field
    from robot.geometry import Pose2, Twist2
    from robot.interface import Frame, Reading, RepositionableRobot, Robot
    from robot.localization.estimate import Estimate
    from robot.localization.filter import Filter, Setup
    from robot.localization.localizer import Localizer
    from robot.localization.parameters import FilterParameters, LocalizationParameters
    from robot.scan import Scan
    from robot.scanning.line_scanner import LineScanner

__all__ = [
    "MAPS",
    "BrickPoseError",
    "Config",
    "DriveCommand",
    "Engine",
    "Estimate",
    "Feature",
    "Field",
    "FigureEightCommand",
    "Filter",
    "FilterParameters",
    "Frame",
    "LineScanner",
    "LocalizationParameters",
    "Localizer",
    "PlaceCommand",
    "Pose2",
    "Program",
    "Reading",
    "RepositionableRobot",
    "Robot",
    "RobotSpec",
    "Scan",
    "ScatterCommand",
    "SetParametersCommand",
    "SetPoseCommand",
    "Setup",
    "Snapshot",
    "StopCommand",
    "Twist2",
    "build_program",
    "load_config",
    "load_field",
    "view",
]

_HOMES = {
    "MAPS": "app.settings.config",
    "BrickPoseError": "robot.errors",
    "Config": "app.settings.config",
    "DriveCommand": "app.messages.driving_commands",
    "Engine": "app.engine.engine",
    "Estimate": "robot.localization.estimate",
    "Feature": "app.feature",
    "Field": "robot.fields.field",
    "FigureEightCommand": "app.messages.driving_commands",
    "Filter": "robot.localization.filter",
    "FilterParameters": "robot.localization.parameters",
    "Frame": "robot.interface",
    "LineScanner": "robot.scanning.line_scanner",
    "LocalizationParameters": "robot.localization.parameters",
    "Localizer": "robot.localization.localizer",
    "PlaceCommand": "app.messages.commands",
    "Pose2": "robot.geometry",
    "Program": "app.engine.program",
    "Reading": "robot.interface",
    "RepositionableRobot": "robot.interface",
    "Robot": "robot.interface",
    "RobotSpec": "robot.description.spec",
    "Scan": "robot.scan",
    "ScatterCommand": "app.messages.commands",
    "SetParametersCommand": "app.messages.commands",
    "SetPoseCommand": "app.messages.commands",
    "Setup": "robot.localization.filter",
    "Snapshot": "app.engine.snapshot",
    "StopCommand": "app.messages.driving_commands",
    "Twist2": "robot.geometry",
    "build_program": "app.engine.build",
    "load_config": "app.settings.config",
    "load_field": "robot.fields.field_loading",
    "view": "app.page.notebook",
}
"""Module of each public name."""


def __getattr__(name: str) -> Any:
    """Import a public name when it is first asked for."""
    if name not in _HOMES:
        raise AttributeError(f"brickpose has no {name!r}; it has {', '.join(__all__)}")
    import_module("app")  # so that the robot's rooms, too, have what features add
    value = globals()[name] = getattr(import_module(_HOMES[name]), name)
    return value


def __dir__() -> list[str]:
    return __all__
