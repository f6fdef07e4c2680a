"""Decides what drives (a person, a programme or nothing), and until when."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol

from robot.driving.differential_drive import DifferentialDrive
from robot.driving.drive_controller import DriveController, lapsed
from robot.driving.figure_eight import FigureEight
from robot.driving.odometry import OdometryState
from robot.geometry import Pose2, Twist2

GAP_S = 5.0
"""A programme that is renewed within this time [s] continues where it was; the robot stands until
then, and so does one that explores. Otherwise a moment without network would lose a minute of
driving, and a figure-eight would begin again wherever a busy computer left the robot. A page that
loses the network for 2 s is back after 2 to 3.3 s, as it tries again once a second: half of this
time would end what it drives, twice of it would only stand for longer when it never comes back."""

Mode = str
"""``idle``, ``drive``, ``figure_eight``, ``explore``, or the name of a feature's programme."""


class Way(Protocol):
    """A way by odometry, as ``robot.driving.route.Route``."""

    goal: Pose2
    """In the frame ``odom``."""

    def twist(self, pose: Pose2) -> Twist2 | None:
        """Return the velocity at a pose of odometry; None at the end."""
        ...


@dataclass(frozen=True)
class Programme:
    """What the robot drives by itself, from a start on: a velocity for each moment."""

    mode: Mode
    velocity: Callable[[float], Twist2]
    """At a time after the start [s]."""
    length: float = math.inf
    """When it is over [s]."""
    anywhere: bool = False
    """Whether it goes on where the robot is put."""


class Driving:
    """Mode and twist of the drive; a command ends if it is not renewed within the time-out."""

    def __init__(
        self, controller: DriveController, timeout: float, eight: FigureEight | None = None
    ) -> None:
        self.mode: Mode = "idle"
        self.route: Way | None = None
        """The route that explores; None stands."""
        self.halted = ""
        """Why what drove last was stopped, in words for people; empty if somebody wanted it."""
        self._controller = controller
        self._timeout = timeout
        self._eight = eight or FigureEight()
        self._programme: Programme | None = None
        self._pace = 1.0
        """Factor on the speed of the figure-eight in the settings."""
        self._began = 0.0
        self._renewed = 0.0
        self._updated = 0.0
        self._held = False

    @property
    def goal(self) -> Pose2 | None:
        """Where the route leads, in the frame of odometry; None without one."""
        return None if self.route is None else self.route.goal

    @property
    def kinematics(self) -> DifferentialDrive:
        """The wheels that limit the robot's speed."""
        return self._controller.kinematics

    @kinematics.setter
    def kinematics(self, kinematics: DifferentialDrive) -> None:
        self._controller.kinematics = kinematics

    @property
    def state(self) -> tuple[Any, ...]:
        """What the next ticks depend on, for ``restore``; who drives by hand is not in it."""
        return self.route, self.mode, self.programme, self._began, self._renewed, self._updated

    def restore(self, state: tuple[Any, ...]) -> None:
        """Continue from another state."""
        self.route, self.mode, self._programme, *times = state
        self._began, self._renewed, self._updated = times

    def drive(self, twist: Twist2, stamp: float) -> None:
        """Drive with the twist that a person commands."""
        self.mode = "drive"
        self._controller.command(twist, stamp)

    def figure_eight(
        self, stamp: float, speed: float | None = None, *, start: bool = False
    ) -> None:
        """Start or renew the figure-eight; with another speed [m/s] it continues where it is."""
        pace = 1.0 if speed is None else speed / self._eight.speed
        if start or self.mode != "figure_eight":
            self._begin(Programme("figure_eight", self._eight_velocity), stamp)
        elif pace != self._pace:
            self._began = stamp - (stamp - self._began) * self._pace / pace
        self._pace = pace
        self._renewed = stamp

    def perform(self, programme: Programme, stamp: float, *, start: bool) -> None:
        """Start or renew a programme; another one of the same mode takes its place."""
        if start and self.programme is not programme:
            self._begin(programme, stamp)
        self._renewed = stamp

    @property
    def programme(self) -> Programme | None:
        """What the robot drives by itself now; None if it does not."""
        programme = self._programme
        return programme if programme and programme.mode == self.mode else None

    def _begin(self, programme: Programme, stamp: float) -> None:
        self.mode = programme.mode
        self._programme = programme
        self._began = self._updated = stamp

    def _eight_velocity(self, elapsed: float) -> Twist2:
        twist = self._eight.twist(elapsed * self._pace)
        return Twist2(twist.v * self._pace, twist.omega * self._pace)

    def explore(self, stamp: float, *, start: bool) -> None:
        """Start or renew the exploration."""
        if start and self.mode != "explore":
            self.mode = "explore"
            self.route = None
        self._renewed = stamp

    def stop(self, why: str = "") -> None:
        """Stand still at once; ``why``, in words for people, if nobody wanted it."""
        if self.mode != "idle":
            self.halted = why
        self.mode = "idle"
        self._controller.stop()

    def hold(self) -> None:
        """Stand at this tick, as the robot does not answer; what drives goes on with the next."""
        self._held = True

    def update(self, odometry: OdometryState) -> Twist2:
        """Return the twist to apply at a pose in the odom frame."""
        stamp = odometry.stamp
        stands = self._held or lapsed(stamp, self._renewed + self._timeout)
        if programme := self.programme:
            self._follow_programme(programme, stamp, not stands)
        elif self.mode == "explore":
            self._follow_route(odometry, stands)
        elif self._held:
            self.stop()
        self._updated, self._held = stamp, False
        twist = self._controller.update(stamp)
        if not self._controller.active:
            self.mode = "idle" if self.mode == "drive" else self.mode
        return twist

    def _follow_route(self, odometry: OdometryState, stands: bool) -> None:
        """Follow the route; stand at its end, and while the command is not renewed."""
        if stands:
            if odometry.stamp - self._renewed < GAP_S:
                self._controller.stop()
            else:
                self.stop()
            return
        route = self.route
        twist = None if route is None else route.twist(odometry.odom_from_robot)
        if twist is not None:
            self._controller.command(twist, odometry.stamp)
            return
        self._controller.stop()
        self.route = None

    def _follow_programme(self, programme: Programme, stamp: float, renewed: bool) -> None:
        """Continue a programme; stand if it is not renewed."""
        if not renewed and stamp - self._renewed < GAP_S:
            self._controller.stop()
            # The programme continues where it was.
            self._began += stamp - self._updated
            return
        elapsed = stamp - self._began
        if not renewed or lapsed(elapsed, programme.length):
            self.stop()
        else:
            self._controller.command(programme.velocity(elapsed), stamp)
