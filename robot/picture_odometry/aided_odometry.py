"""Aided odometry: dead reckoning by wheels that looks at pictures, and may be put right by them."""

from __future__ import annotations

from bisect import bisect_left
from dataclasses import replace

import numpy as np

from robot.driving.odometry import Odometry, OdometryState
from robot.geometry import Array, Pose2, interpolate, turned_covariance
from robot.interface import Frame, Reading
from robot.picture_odometry.odometer import PictureMotion, PictureOdometer

LEAST_WHEELS = np.diag([1e-8, 1e-8, 1e-7])
"""Covariance of a step by the wheels even if they stand [m^2, m^2, rad^2]: they have play."""


class PictureAidedOdometry(Odometry):
    """Odometry that measures each picture's motion, and may correct its poses by it."""

    def __init__(self, wheels: Odometry, odometer: PictureOdometer, *, fuse: bool) -> None:
        """Go on from an odometry by wheels alone.

        Args:
            wheels: the odometry so far; it is not used any more.
            odometer: measures motion in pictures.
            fuse: whether poses are corrected; otherwise they are as they were, to the last bit.
        """
        self.__dict__.update(wheels.__dict__)
        self.odometer = odometer
        self.fuse = fuse
        self.delay = 0.0
        """How much later than exposed pictures are stamped [s]."""
        self.newest: PictureMotion | None = None
        """What the newest picture told; None of a first one."""
        self._exposed: float | None = None

    def update(self, reading: Reading) -> OdometryState:
        """Add one reading of the joints, and its picture if it has one; return the new state.

        Raises:
            ValueError: the stamp is not later than the previous one.
        """
        state = super().update(reading)
        if reading.frame is not None:
            self._look(Frame(reading.frame.stamp - self.delay, reading.frame.image))
            state = self._history[-1]
        return state

    def _look(self, frame: Frame) -> None:
        before, self._exposed = self._exposed, self.odometer.exposed(frame)
        try:
            moved = None
            if before is not None:
                begin = self.at(before).odom_from_robot
                moved = begin.inverse() @ self.at(self._exposed).odom_from_robot
        except LookupError:
            moved = None
        self.newest = self.odometer.measure(frame, moved)
        if self.fuse and self.newest is not None and self.newest.seen:
            self._correct(self.newest)

    def _correct(self, seen: PictureMotion) -> None:
        """Move the poses since the first picture to where both measurements say together."""
        by_wheels = self._step_covariance(seen.predicted)
        # A Kalman filter's update of the wheels' motion by the picture's.
        gain = by_wheels @ np.linalg.inv(by_wheels + seen.covariance)
        apart = seen.predicted.inverse() @ seen.motion
        better = Pose2.from_array(gain @ apart.to_array())
        begin = self.at(seen.begin)
        known = (np.eye(3) - gain) @ by_wheels
        turned = turned_covariance(known - by_wheels, begin.odom_from_robot.theta)
        end = begin.odom_from_robot @ seen.predicted
        put_right = end @ better @ end.inverse()
        first = bisect_left(self._history, seen.begin, key=lambda state: state.stamp)
        for place in range(first, len(self._history)):
            state = self._history[place]
            part = min(1.0, (state.stamp - seen.begin) / (seen.end - seen.begin))
            moved = interpolate(Pose2(), put_right, part) @ state.odom_from_robot
            covariance = _positive(state.covariance + part * turned)
            self._history[place] = replace(state, odom_from_robot=moved, covariance=covariance)

    def _step_covariance(self, moved: Pose2) -> Array:
        """Return the covariance (3, 3) of a motion by the wheels (as ``_spread``), base frame."""
        track = self.drive.track
        aside = moved.theta * track / 2
        errors = self._settings.wheel_error * np.abs([moved.x - aside, moved.x + aside])
        # As in eq. 5.9 of Siegwart and Nourbakhsh, at half of the turn, in the frame of its begin.
        leaning = moved.x / (2 * track)
        by_wheel = np.array([[0.5, 0.5], [-leaning, leaning], [-1 / track, 1 / track]])
        grown: Array = by_wheel * errors @ by_wheel.T + LEAST_WHEELS
        return grown


def _positive(covariance: Array) -> Array:
    """Return a covariance without the negative variances that taking away may leave."""
    values, axes = np.linalg.eigh((covariance + covariance.T) / 2)
    positive: Array = axes * np.maximum(values, 0.0) @ axes.T
    return positive
