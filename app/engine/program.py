"""A running robot with its engine, as page, ROS 2 and recordings see it."""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from app.engine.engine import Engine
from app.engine.own_models.own_models import OwnChoice
from app.settings.config import Config
from robot.fields.field import Field
from robot.interface import Robot
from robot.scanning.line_scanner import LineScanner


@dataclass(frozen=True)
class Program:
    """The parts that others need to see."""

    engine: Engine
    robot: Robot
    field: Field
    scanner: LineScanner
    config: Config
    pose_file: Path
    """Where the pose is kept for the next start."""
    given: OwnChoice
    """Models of the user's own at the start."""
    loop: Callable[[threading.Event], None] | None = None
    """Runs until the event is set, in place of the engine's own loop, if the robot is a recording;
    then nobody can drive it."""
