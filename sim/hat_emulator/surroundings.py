"""Surroundings of the board: motors on a table, or a robot on a field that they drive."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Protocol

import numpy as np

from robot.description.spec import RobotSpec
from robot.geometry import Pose2
from sim.exposures import Exposures
from sim.floor_camera import CameraSettings
from sim.hat.motor_figures import MotorFigures
from sim.hat.plants import FreeMotors, Plants
from sim.hat_emulator.physics_wheels import PhysicsWheels
from sim.hat_emulator.picture_server import Shot
from sim.physics import PhysicsWorld
from sim.simulated import PastPoses
from sim.world import World, WorldError


class Surroundings(Protocol):
    """The motors that the board's drivers turn, and the robot that they move."""

    @property
    def plants(self) -> Plants:
        """The motors."""
        ...

    @property
    def truth(self) -> Pose2:
        """True pose of the robot in the map.

        Raises:
            WorldError: there is no robot.
        """
        ...

    def place(self, pose: Pose2) -> None:
        """Place the robot at a pose in the map, as by hand.

        Raises:
            WorldError: there is no robot.
            WorldError: the pose is not finite.
        """
        ...

    def close(self) -> None:
        """Release all resources; may be called twice."""
        ...


class Table:
    """Motors that turn freely; no robot."""

    def __init__(self, figures: Mapping[int, MotorFigures]) -> None:
        """Put motors on the table, with ``figures`` by port, 0 to 3."""
        self.plants = FreeMotors(figures)

    @property
    def truth(self) -> Pose2:
        """Raise a ``WorldError``: there is no robot."""
        raise WorldError("there is no robot: the motors turn freely (--world free)")

    def place(self, pose: Pose2) -> None:
        """Raise a ``WorldError``: there is no robot."""
        raise WorldError("there is no robot: the motors turn freely (--world free)")

    def close(self) -> None:
        """Do nothing: there is nothing to release."""


class RobotOnField:
    """A robot that stands on the floor on its wheels, and may have a camera."""

    def __init__(
        self,
        world: PhysicsWorld,
        spec: RobotSpec,
        figures: Mapping[int, MotorFigures] | None = None,
    ) -> None:
        """Put motors on a world made from ``spec``; without ``figures``, ``spec`` names them."""
        self.plants = PhysicsWheels(world, spec, figures, self._look)
        self._world = world
        self._feed: CameraFeed | None = None

    def has_camera(
        self,
        settings: CameraSettings,
        readout: float,
        wall: Callable[[float], float],
        take: Callable[[Shot], None],
    ) -> None:
        """Give the robot a camera; for the arguments see ``CameraFeed``."""
        self._feed = CameraFeed(self._world, settings, readout, wall, take)

    @property
    def truth(self) -> Pose2:
        """True pose of the robot frame in the map."""
        return self._world.pose

    def place(self, pose: Pose2) -> None:
        """Place it at a pose in the map, at rest; unfinished pictures are lost."""
        self._world.place(pose)
        if self._feed is not None:
            self._feed.moved(self.plants.now)

    def close(self) -> None:
        """Close the world."""
        self._world.close()

    def _look(self, current: float) -> None:
        if self._feed is not None:
            self._feed.look(current)


class CameraFeed:
    """Records the world's pose after each step, and hands over each exposed shot."""

    def __init__(
        self,
        world: World,
        settings: CameraSettings,
        readout: float,
        wall: Callable[[float], float],
        take: Callable[[Shot], None],
    ) -> None:
        """
        Args:
            readout: time from the first row's exposure to the last row's [s].
            wall: converts the world's time [s] to CLOCK_MONOTONIC [s].
            take: called with each shot, as soon as its last row is exposed.
        """
        self._world = world
        self._settings = settings
        self._exposures = Exposures(settings, readout, np.random.default_rng(0))
        self._past = PastPoses()
        self._wall = wall
        self._take = take

    def look(self, current: float) -> None:
        """Record the world after a step to ``current`` [s] of its time; hand over a due shot."""
        self._past.remember(current, self._world.pose, self._world.twist)
        exposed = self._exposures.newest(current - self._exposures.until_read)
        if exposed is None:
            return
        pose, twist = self._past.at(exposed)
        stamp = self._wall(exposed + self._settings.stamp_error)
        self._take(Shot(stamp, self._wall(exposed + self._exposures.until_here), pose, twist))

    def moved(self, current: float) -> None:
        """Forget the past, since the robot was placed elsewhere: unfinished pictures are lost."""
        self._past.forget()
        self._exposures.skip(current)
