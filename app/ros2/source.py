"""The constant data that messages are made from, besides the snapshot."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from app.engine.program import Program
from app.ros2.clock import RosClock
from app.ros2.links import Links
from app.settings.ros2 import Ros2Settings
from robot.description.spec import RobotSpec
from robot.driving.differential_drive import DifferentialDrive
from robot.fields.field import Field
from robot.scanning.line_scanner import LineScanner


@dataclass(frozen=True)
class TopicSource:
    """One robot on one field, with the settings of its topics."""

    robot_name: str
    spec: RobotSpec
    field: Field
    scanner: LineScanner
    drive: DifferentialDrive
    settings: Ros2Settings
    timeout: float
    """How long a drive command holds [s]."""
    clock: RosClock

    @classmethod
    def of(cls, program: Program) -> TopicSource:
        """Return the source for a program."""
        spec, config = program.robot.spec, program.config
        return cls(
            program.robot.name,
            spec,
            program.field,
            program.scanner,
            DifferentialDrive(spec, config.drive.multipliers),
            config.ros2,
            config.drive.cmd_vel_timeout,
            RosClock(),
        )

    @cached_property
    def links(self) -> Links:
        """The robot's links."""
        return Links.of(self.spec, self.settings, self.scanner.settings.centre_x)

    @cached_property
    def range_min(self) -> float:
        """The shortest distance at which any ray can see [m]."""
        return float(np.nanmin(self.scanner.table.limits[:, 0]))
