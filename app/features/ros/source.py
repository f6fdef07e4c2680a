"""What messages are made from, besides the snapshot: field, settings, robot, and the clock."""

from __future__ import annotations

import math
import threading
import time
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from app.engine.program import Program
from app.engine.snapshot import Snapshot
from app.features.ros.links import Links
from app.settings.groups import Ros2Settings
from robot.description.spec import RobotSpec
from robot.driving.differential_drive import DifferentialDrive
from robot.fields.field import Field
from robot.scanning.line_scanner import LineScanner

UNCHANGING = -math.inf
"""The stamp of content that never changes."""

JUMPED_NS = 200_000_000
"""If the offset between wall clock and robot clock changes by more, one of them was set."""

OLD_S = 1.0
"""After this time without a check of the clocks, one of them may have been set unnoticed."""


class RosClock:
    """Converts the robot's stamps to nanoseconds since 1970.

    The offset between the two clocks is measured once, so that the intervals between stamps are
    kept. It is measured again when the clocks have diverged: a Pi without a battery gets the date
    from the network minutes after its start, and a replay jumps.
    """

    def __init__(self) -> None:
        self._offset: int | None = None
        self._holders = 0
        self._followed = 0.0
        """When the clocks were last checked, on the computer's monotonic clock [s]."""
        self._lock = threading.Lock()

    def follow(self, snapshot: Snapshot) -> None:
        """Check whether the clocks still agree; called at each tick."""
        looked = time.monotonic()
        age = looked - snapshot.published
        current = time.time_ns() - round(age * 1e9)  # wall clock when the snapshot was made
        offset = current - round(snapshot.stamp * 1e9)
        with self._lock:
            self._followed = looked
            apart = self._offset is None or abs(offset - self._offset) > JUMPED_NS
            if self._offset is None or (apart and not self._holders):
                self._offset = offset

    def ns(self, stamp: float) -> int:
        """ROS time [ns] at a stamp of the robot [s]."""
        return round(stamp * 1e9) + (self._offset or 0)

    def age(self, time_ns: int) -> float:
        """Age of a ROS time by the wall clock [s]."""
        return (time.time_ns() - time_ns) / 1e9

    def hold(self) -> None:
        """Keep the offset until ``release``, so that a recording has one time base.

        If nobody held the offset and it was not checked for ``OLD_S``, the next tick measures it
        again: the clock may have been set since the last recording.
        """
        with self._lock:
            if not self._holders and time.monotonic() - self._followed > OLD_S:
                self._offset = None
            self._holders += 1

    def release(self) -> None:
        """End one ``hold``; after the last one, the offset follows the clocks again."""
        with self._lock:
            self._holders -= 1


@dataclass(frozen=True)
class KnownRobot:
    """The robot as it is known at a tick, and what follows from that."""

    spec: RobotSpec
    scanner: LineScanner
    drive: DifferentialDrive
    settings: Ros2Settings

    @cached_property
    def links(self) -> Links:
        """The robot's links."""
        return Links.of(self.spec, self.settings, self.scanner.settings.centre_x)

    @cached_property
    def range_min(self) -> float:
        """The shortest distance at which any ray can see [m]."""
        return float(np.nanmin(self.scanner.table.limits[:, 0]))


@dataclass
class TopicSource:
    """One robot on one field, with the settings of its topics."""

    robot_name: str
    field: Field
    settings: Ros2Settings
    timeout: float
    """How long a drive command holds [s]."""
    clock: RosClock
    _robot: KnownRobot

    @classmethod
    def of(cls, program: Program) -> TopicSource:
        """Return the source for a program."""
        spec, config = program.engine.spec, program.config
        drive = DifferentialDrive(spec, config.drive.multipliers)
        scanner = program.engine.scanner
        return cls(
            program.robot.name,
            program.field,
            config.ros2,
            config.drive.cmd_vel_timeout,
            RosClock(),
            KnownRobot(spec, scanner, drive, config.ros2),
        )

    def robot(self, snapshot: Snapshot) -> KnownRobot:
        """Return the robot as it is known at a tick; only a calibration makes another."""
        known, spec = self._robot, snapshot.spec
        if known.spec is not spec or known.settings is not self.settings:
            assert snapshot.filter.scanner is not None  # a program with topics has a scanner
            known = KnownRobot(spec, snapshot.filter.scanner, known.drive.of(spec), self.settings)
            self._robot = known
        return known
