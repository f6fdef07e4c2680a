"""Decides what drives (a person, a programme or nothing), and until when."""

from __future__ import annotations

from typing import Literal

from robot.calibration import programme
from robot.driving.differential_drive import DifferentialDrive
from robot.driving.drive_controller import DriveController
from robot.driving.figure_eight import FigureEight
from robot.driving.odometry import OdometryState
from robot.driving.route import Route
from robot.geometry import Array, Pose2, Twist2

GAP_S = 3.0
"""A programme that is renewed within this time continues where it was; the robot stands until then.
Otherwise a moment without network would lose a minute of driving, and a figure-eight would begin
again wherever a busy computer left the robot."""

Mode = Literal["idle", "drive", "figure_eight", "calibrate", "explore"]


class Driving:
    """Mode and twist of the drive; a command ends if it is not renewed within the time-out."""

    def __init__(
        self, controller: DriveController, timeout: float, eight: FigureEight | None = None
    ) -> None:
        self.mode: Mode = "idle"
        self.route: Route | None = None
        """The route that explores; None stands. Another thread may set the next one."""
        self._controller = controller
        self._timeout = timeout
        self._eight = eight or FigureEight()
        self._pace = 1.0
        """Factor on the speed of the figure-eight in the settings."""
        self._began = 0.0
        self._renewed = 0.0
        self._updated = 0.0

    @property
    def kinematics(self) -> DifferentialDrive:
        """The wheels that limit the robot's speed."""
        return self._controller.kinematics

    @kinematics.setter
    def kinematics(self, kinematics: DifferentialDrive) -> None:
        self._controller.kinematics = kinematics

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
            self.mode = "figure_eight"
            self._began = self._updated = stamp
        elif pace != self._pace:
            self._began = stamp - (stamp - self._began) * self._pace / pace
        self._pace = pace
        self._renewed = stamp

    def figure_eight_path(self, robot: Pose2) -> Array:
        """Return the path (n, 2) [m] of a figure-eight that begins at a pose."""
        return robot.apply(self._eight.path())

    def calibrate(self, stamp: float, *, start: bool) -> None:
        """Start or renew the drive of a calibration."""
        if start and self.mode != "calibrate":
            self.mode = "calibrate"
            self._began = self._updated = stamp
        self._renewed = stamp

    def explore(self, stamp: float, *, start: bool) -> None:
        """Start or renew the exploration."""
        if start and self.mode != "explore":
            self.mode = "explore"
            self.route = None
        self._renewed = stamp

    def stop(self) -> None:
        """Stand still at once."""
        self.mode = "idle"
        self._controller.stop()

    def update(self, odometry: OdometryState) -> Twist2:
        """Return the twist to apply at a pose in the odom frame."""
        stamp = odometry.stamp
        if self.mode in ("figure_eight", "calibrate"):
            self._follow_programme(stamp, self._lapsed(stamp))
        elif self.mode == "explore":
            self._follow_route(odometry)
        self._updated = stamp
        twist = self._controller.update(stamp)
        if not self._controller.active:
            self.mode = "idle" if self.mode == "drive" else self.mode
        return twist

    def _lapsed(self, stamp: float) -> bool:
        return stamp - self._renewed >= self._timeout - 5e-7

    def _follow_route(self, odometry: OdometryState) -> None:
        """Follow the route; stand at its end, and stop if the command is not renewed."""
        if self._lapsed(odometry.stamp):
            self.stop()
            return
        route = self.route
        twist = None if route is None else route.twist(odometry.odom_from_robot)
        if twist is not None:
            self._controller.command(twist, odometry.stamp)
            return
        self._controller.stop()
        if self.route is route:
            self.route = None

    def _follow_programme(self, stamp: float, lapsed: bool) -> None:
        """Continue the programme; stand if it is not renewed."""
        if lapsed and stamp - self._renewed < GAP_S:
            self._controller.stop()
            # The programme continues where it was.
            self._began += stamp - self._updated
            return
        elapsed = stamp - self._began
        if lapsed or (self.mode == "calibrate" and elapsed >= programme.USUAL_S - 5e-7):
            self.stop()
        elif self.mode == "calibrate":
            self._controller.command(programme.velocity(elapsed), stamp)
        else:
            twist = self._eight.twist(elapsed * self._pace)
            twist = Twist2(twist.v * self._pace, twist.omega * self._pace)
            self._controller.command(twist, stamp)
