"""The engine on a recording: between two ticks it can stand, and go back to an earlier state."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from app.engine.checkpoint import Checkpoint, Keeper
from app.engine.engine import Engine
from app.engine.localization import Localization
from app.engine.snapshot import Snapshot
from app.messages.commands import Command, PlaceCommand
from robot.driving.odometry import Odometry, OdometryState
from robot.geometry import Pose2, Twist2
from robot.interface import Frame, Reading


@dataclass(frozen=True)
class EngineState:
    """What the next ticks depend on, besides the robot."""

    odometry: Odometry
    localization: Localization
    map_from_odom: Pose2
    """Where dead reckoning began."""
    odom_from_scan: Pose2 | None = None
    picture_stamp: float | None = None
    """Of the last picture [s]; the picture itself is not kept, as the next one replaces it."""


class ReplayEngine(Engine):
    """Steps when it is told to, with the commands that it is told."""

    @property
    def odometry(self) -> Odometry:
        """Dead reckoning as it is now."""
        return self._odometry

    @property
    def state(self) -> EngineState:
        """What the next ticks depend on."""
        return EngineState(
            self._odometry,
            self.localization,
            self._map_from_odom,
            self._odom_from_scan,
            None if self._frame is None else self._frame.stamp,
        )

    @state.setter
    def state(self, state: EngineState) -> None:
        self._odometry = state.odometry
        self.localization = state.localization
        self._map_from_odom = state.map_from_odom
        self._odom_from_scan = state.odom_from_scan
        stamp = state.picture_stamp
        self._frame = None if stamp is None else Frame(stamp, np.zeros((1, 1), np.uint8))

    def advance(self, commands: tuple[Command, ...]) -> Snapshot:
        """One tick with these commands; nobody sees it yet.

        Raises:
            RobotError: the recording is over, or damaged from here on.
        """
        snapshot = self._advance(self.robot.read(), commands)
        self._stands = snapshot.reading, snapshot.twist
        return snapshot

    def linger(self, commands: tuple[Command, ...]) -> Snapshot:
        """Take commands without any time going by; after the first tick."""
        reading, twist = self._stands
        self._meter.begin()
        self.localization.own.look_again()
        self._mind_own_models(reading.stamp)
        odometry = self._odometry.at(reading.stamp)
        self._take(commands, reading.stamp, odometry)
        self._stand_while_faulty(reading)
        return self._snapshot(reading, commands, odometry, twist)

    def publish(self, snapshot: Snapshot) -> None:
        """Let everybody see it."""
        self._publish(snapshot)

    def fail(self, message: str) -> None:
        """Say that it is over, and why."""
        self._publish_failure(message)

    def report(self, topic: str, message: str | None) -> None:
        """Say what is wrong with a topic, or None that nothing is."""
        self._problems.report(topic, self._stands[0].stamp, message)

    def keep(self, keeper: Keeper, more: object) -> Checkpoint:
        """Keep the state, with something more that belongs to it.

        Raises:
            CheckpointError: a user's own model cannot be copied.
        """
        own = self.localization.own
        return keeper.keep((self.state, own.sensor, own.motion, more))

    def bring_back(self, checkpoint: Checkpoint) -> object:
        """Go back to a state; returns what was kept with it."""
        state, sensor, motion, more = checkpoint.restore()
        self.state = state
        self.localization.own.put_back(sensor, motion)
        found: object = more
        return found

    _stands: tuple[Reading, Twist2]
    """The last tick's."""

    def _take(self, commands: tuple[Command, ...], stamp: float, odometry: OdometryState) -> None:
        super()._take(commands, stamp, odometry)
        for command in commands:
            if isinstance(command, PlaceCommand):
                # The robot was put elsewhere then: dead reckoning goes on from there.
                placed = Pose2(command.x, command.y, command.theta)
                self._map_from_odom = placed @ odometry.odom_from_robot.inverse()
