"""How the robot moved between pictures: by odometry from a file, or as before without any."""

from __future__ import annotations

from bisect import bisect_left
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from app.lab.trajectories.trajectory import Trajectory
from robot.geometry import Array, Pose2, Twist2, compose, interpolate, wrap_angle

PAST_END = 0.1
"""For this long before the first pose and after the last, the robot is taken to stand there [s]."""
SHORT = 0.02
"""The velocity at a stamp is the mean over this time before and after it [s]."""


class Motion(Protocol):
    """The robot's pose in a frame that drifts against the map, by stamp."""

    def at(self, stamp: float) -> Pose2 | None:
        """Return the pose at a stamp [s]; None if it is not known."""
        ...


class RecordedOdometry:
    """Odometry of a file, interpolated between its poses."""

    def __init__(self, trajectory: Trajectory) -> None:
        self._stamps = trajectory.stamps.tolist()
        self._poses = [Pose2.from_array(pose) for pose in trajectory.poses]

    def at(self, stamp: float) -> Pose2 | None:
        """Return the pose at a stamp; None beyond both ends."""
        if not self._stamps[0] - PAST_END <= stamp <= self._stamps[-1] + PAST_END:
            return None
        after = min(max(bisect_left(self._stamps, stamp), 1), len(self._stamps) - 1)
        begin, end = self._stamps[after - 1], self._stamps[after]
        part = min(max((stamp - begin) / (end - begin), 0.0), 1.0)
        return interpolate(self._poses[after - 1], self._poses[after], part)


class SteadyMotion:
    """No odometry: the robot goes on as it went between the last two pictures."""

    def __init__(self) -> None:
        self._stamp = 0.0
        self._pose = Pose2()
        self._twist = Twist2()
        self._estimate: tuple[float, Pose2] | None = None

    def at(self, stamp: float) -> Pose2 | None:
        """Return the pose at a stamp, from the last pose that was estimated."""
        return self._pose @ self._twist.integrate(max(stamp - self._stamp, 0.0))

    def learn(self, stamp: float, estimate: Pose2) -> None:
        """Take the velocity from an estimate in the map, and the one before it."""
        present = self.at(stamp) or Pose2()
        if self._estimate is not None:
            before, pose = self._estimate
            moved = pose.inverse() @ estimate
            period = stamp - before
            self._twist = Twist2(moved.x / period, moved.theta / period)
        self._stamp, self._pose, self._estimate = stamp, present, (stamp, estimate)


def twist_at(motion: Motion, stamp: float) -> Twist2:
    """Return the velocity at a stamp [s], as far as it is known."""
    begin, end = motion.at(stamp - SHORT), motion.at(stamp + SHORT)
    if begin is None or end is None:
        return Twist2()
    moved = begin.inverse() @ end
    return Twist2(moved.x / (2 * SHORT), moved.theta / (2 * SHORT))


@dataclass(frozen=True, slots=True)
class GuessedStep:
    """A motion model for steps that are a guess: their errors do not depend on their size."""

    sd_xy: float
    """[m] a step"""
    sd_theta: float
    """[rad] a step"""

    def sample(self, poses: Array, moved: Pose2, rng: np.random.Generator) -> Array:
        """Draw where each particle (n, 3) went."""
        drawn = compose(poses, moved.to_array()[None])
        drawn += rng.normal(0.0, (self.sd_xy, self.sd_xy, self.sd_theta), poses.shape)
        drawn[:, 2] = wrap_angle(drawn[:, 2])
        return drawn

    def moments(self, moved: Pose2) -> tuple[Pose2, Array]:
        """Return mean and covariance (3, 3) [m, m, rad] of where a step ends."""
        return moved, np.diag(np.square([self.sd_xy, self.sd_xy, self.sd_theta]))
