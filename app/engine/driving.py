"""Decides who drives (a person, a programme or nobody) and until when."""

from __future__ import annotations

from typing import Literal

from robot.calibration import programme
from robot.driving.differential_drive import DifferentialDrive
from robot.driving.drive_controller import DriveController
from robot.driving.figure_eight import FigureEight
from robot.driving.odometry import OdometryState
from robot.geometry import Twist2

Mode = Literal["idle", "drive", "figure_eight", "calibrate"]


class Driving:
    """Mode and twist of the drive; a command that is not renewed within the time-out ends."""

    def __init__(
        self, controller: DriveController, timeout: float, eight: FigureEight | None = None
    ) -> None:
        self.mode: Mode = "idle"
        self._controller = controller
        self._timeout = timeout
        self._eight = eight or FigureEight()
        self._began = 0.0
        self._renewed = 0.0
        self._over = False
        """Whether a calibration's drive has ended that may still be renewed."""

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

    def figure_eight(self, stamp: float) -> None:
        """Start the figure-eight, or renew it."""
        if self.mode != "figure_eight":
            self.mode = "figure_eight"
            self._began = stamp
        self._renewed = stamp

    def calibrate(self, stamp: float) -> None:
        """Start the drive of a calibration, or renew it.

        Who goes on renewing after its end has to let go before another one starts.
        """
        held = self._over and stamp - self._renewed < self._timeout
        self._renewed = stamp
        if self.mode != "calibrate" and not held:
            self.mode = "calibrate"
            self._began, self._over = stamp, False

    def stop(self) -> None:
        """Stand still at once."""
        self._over = self._over or self.mode == "calibrate"
        self.mode = "idle"
        self._controller.stop()

    def update(self, odometry: OdometryState) -> Twist2:
        """Return the twist to apply where the robot is now by odometry."""
        stamp = odometry.stamp
        if self.mode in ("figure_eight", "calibrate"):
            if stamp - self._renewed >= self._timeout - 5e-7 or self._finished(stamp):
                self.stop()
            else:
                self._controller.command(self._wanted(stamp - self._began), stamp)
        twist = self._controller.update(stamp)
        if not self._controller.active:
            self.mode = "idle" if self.mode == "drive" else self.mode
        return twist

    def _finished(self, stamp: float) -> bool:
        return self.mode == "calibrate" and stamp - self._began >= programme.USUAL_S - 5e-7

    def _wanted(self, elapsed: float) -> Twist2:
        if self.mode == "calibrate":
            return programme.velocity(elapsed)
        return self._eight.twist(elapsed)
