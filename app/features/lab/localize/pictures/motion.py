"""The robot's motion between pictures, by odometry of a file or by a guess; and stale pictures.

A stale picture has a later stamp, but what it shows has hardly moved. Corners are tracked from one
picture to the next; those on the floor should move as odometry says. If the robot moved far, and
most of them moved much less, the second was exposed soon after the first, and stamped late.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from dataclasses import dataclass
from typing import Any, Protocol

import cv2
import numpy as np
from numpy.typing import NDArray

from app.trajectories.trajectory import Trajectory
from robot.camera import FloorView
from robot.cameras.camera import Picture
from robot.geometry import Array, Pose2, Twist2, compose, interpolate, wrap_angle

PAST_END = 0.1
"""For this long before the first pose and after the last, the robot is taken to stand there [s]."""
SHORT = 0.02
"""The velocity at a stamp is the mean over this time before and after it [s]."""
CORNERS, QUALITY, APART_PX = 300, 0.05, 6.0
"""Most corners that are tracked, their least relative quality, and least distance."""
WINDOW_PX, LEVELS = 21, 4
"""Side of the patches that are compared, and how often the picture is halved before."""
RETURN_PX = 0.7
"""A corner that was tracked there and back must come out this close to where it began."""
FARTHEST = 1.5
"""Corners on the floor beyond this are not used [m]."""
FEWEST = 15
"""Fewest corners that must be tracked."""
LEAST_PX = 60.0
"""Motion of the floor in the picture that odometry must tell, to be compared."""
SHARE = 0.25
"""A picture is stale if its corners moved by less than this share of what odometry says."""
ALIKE = 0.5
"""Without motion to compare, a picture is stale if its grey levels differ by less on average."""


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


def is_stale(before: Picture, picture: Picture, moved: Pose2 | None, view: FloorView) -> bool:
    """Return whether a picture shows what an earlier one showed, although the robot has moved.

    Args:
        before: (h, w, 3) the picture before.
        picture: (h, w, 3) the one to be judged.
        moved: motion between their stamps by odometry; without it only repeats are noticed.
    """
    first, second = (cv2.cvtColor(image, cv2.COLOR_BGR2GRAY) for image in (before, picture))
    if moved is None:
        return repeats(before, picture)
    expected, seen = _moves(first, second, moved, view)
    # A corner that should have left what the lens can show has moved by more than any that did not.
    claimed = np.nan_to_num(np.hypot(*expected.T), nan=np.inf)
    if not len(claimed) or np.median(claimed) < LEAST_PX:
        return False
    return bool(np.median(np.hypot(*seen.T)) < SHARE * np.median(claimed))


def disagreement(before: Picture, picture: Picture, moved: Pose2, view: FloorView) -> float:
    """Return how far corners lie from where a motion would have moved them [px].

    It is their median; infinite where too few corners can be followed.
    """
    first, second = (cv2.cvtColor(image, cv2.COLOR_BGR2GRAY) for image in (before, picture))
    expected, seen = _moves(first, second, moved, view)
    misses = np.nan_to_num(np.hypot(*(expected - seen).T), nan=np.inf)
    return float(np.median(misses)) if len(misses) else math.inf


def _moves(
    first: NDArray[Any], second: NDArray[Any], moved: Pose2, view: FloorView
) -> tuple[Array, Array]:
    """Return by how much corners on the floor should move (n, 2), and do [px]; none if too few."""
    start, end = _tracked(first, second)
    on_floor = view.floor_points(start)
    near = np.hypot(*(on_floor - view.robot_from_camera[:2, 3]).T) < FARTHEST
    if near.sum() < FEWEST:
        return np.empty((0, 2)), np.empty((0, 2))
    return view.pixels(moved.inverse().apply(on_floor[near])) - start[near], (end - start)[near]


def repeats(before: Picture, picture: Picture) -> bool:
    """Return whether two pictures (h, w, 3) are the same but for noise."""
    first, second = (cv2.cvtColor(image, cv2.COLOR_BGR2GRAY) for image in (before, picture))
    return bool(np.abs(first.astype(np.int16) - second).mean() < ALIKE)


def _tracked(first: NDArray[Any], second: NDArray[Any]) -> tuple[Array, Array]:
    """Return where corners are in a picture (n, 2) and where they are in the next [px]."""
    corners: NDArray[Any] | None = cv2.goodFeaturesToTrack(first, CORNERS, QUALITY, APART_PX)
    if corners is None:
        return np.empty((0, 2)), np.empty((0, 2))
    ahead, sure = _flow(corners, first, second)
    back, sure_back = _flow(ahead, second, first)
    kept = sure & sure_back & (np.hypot(*(back - corners)[:, 0].T) < RETURN_PX)
    return corners[kept, 0].astype(np.float64), ahead[kept, 0].astype(np.float64)


def _flow(
    start: NDArray[Any], image: NDArray[Any], other: NDArray[Any]
) -> tuple[NDArray[Any], NDArray[np.bool_]]:
    """Return where points (n, 1, 2) of an image are in another, and which were found (n,)."""
    end, status, _ = cv2.calcOpticalFlowPyrLK(
        image, other, start, np.empty(0), winSize=(WINDOW_PX, WINDOW_PX), maxLevel=LEVELS
    )
    return end, np.asarray(status[:, 0] > 0)
