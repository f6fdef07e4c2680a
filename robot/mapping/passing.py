"""Decides which pictures of a drive bring something new, so that a long drive costs little.

Where the robot has been often, and sees what is drawn, its pictures are only laid on the map: they
say where it is. They are not adjusted with the others, so the adjustment is as large as the floor
is, and not as long as the drive. As soon as something lies elsewhere, pictures are kept again, and
a bridge leads over those that were not.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from robot.calibration.drive_log import DriveLog
from robot.geometry import Array, wrap_angle
from robot.mapping.moving import STEP_M, STEP_RAD

PASSES = 3
"""A place is known if the robot was there so often."""
PASS_S = 5.0
"""Pictures that lie farther apart in time than this are of two passes [s]."""
NEAR, NEAR_TURN = 5 * STEP_M, 5 * STEP_RAD
"""A picture is of the same place if it was taken nearer than this [m, rad]."""
EXPLAINED = 0.9
"""Pictures bring nothing new if so large a share of their edges lies on strokes as of those that
were seen from there before, but for this factor. Not all do: shadows, and tape in corners, do not.
"""
LEAST_SEEN = 0.7
"""... and if they show at least this share of the edges that were seen there before: where tape was
taken away, less is seen."""
TIED = 6
"""A bridge begins where the strokes say well where the robot is: a picture has so many edges there.
"""
PUSHED, PUSHED_TURN = 0.01, 0.06
"""A picture that the map lays farther than this from where the wheels lead is kept [m, rad]: the
robot was pushed, which only the whole adjustment tells well. One picture alone is laid on rough
strokes to 4 mm and 0.023 rad (99 of 100): with 0.004 and 0.02, half an hour on generated-6604 kept
8520 pictures instead of 2331, and its map was no better (0.76 and 0.78 mm)."""
DEFERRED = 0.15
"""Pictures that the map explains wait until they are this share of those that were adjusted."""
BRIDGE_SD = np.array([0.005, 0.005, 0.02])
"""How well the two ends of a bridge are known from each other, beside how well the robot knew where
it was [m, m, rad]: the map that they were laid on may still be bent."""


@dataclass(frozen=True, eq=False)
class Followed:
    """Pictures that were laid on the map one after the other."""

    poses: Array
    """(k, 3) of the robot [m, m, rad]."""
    covariance: Array = field(repr=False)
    """(3, 3) of the last one."""
    first_covariance: Array = field(repr=False)
    """(3, 3) of the first one."""
    seen: NDArray[np.intp]
    """(k,) how many edges each shows."""
    lying: NDArray[np.intp]
    """(k,) how many of them lie on strokes."""

    begin_pose: Array
    """(3,) of the robot at the picture before them [m, m, rad]."""
    steps: Array = field(repr=False)
    """(k, 3) how the robot came to each of them by its wheels [m, m, rad]."""

    @property
    def is_pushed(self) -> bool:
        """Whether it came from one to the next otherwise than by its wheels."""
        before, after = np.vstack([self.begin_pose, self.poses[:-1]]), self.poses
        c, s = np.cos(before[:, 2]), np.sin(before[:, 2])
        dx, dy = (after - before)[:, :2].T
        apart = np.column_stack([c * dx + s * dy, -s * dx + c * dy]) - self.steps[:, :2]
        turned = wrap_angle(after[:, 2] - before[:, 2] - self.steps[:, 2])
        return bool((np.abs(apart) > PUSHED).any() or (np.abs(turned) > PUSHED_TURN).any())

    @property
    def is_tied(self) -> bool:
        """Whether the strokes say well where the robot is at the last pictures."""
        return bool(self.lying.mean() >= TIED)


@dataclass(frozen=True, eq=False)
class Bridges:
    """Steps over pictures that were not kept."""

    before: NDArray[np.intp] = field(default_factory=lambda: np.zeros(0, np.intp))
    """(b,) the last picture before each of them."""
    steps: Array = field(default_factory=lambda: np.zeros((0, 3)))
    """(b, 3) the pose of the next picture that was kept, in the frame of that one [m, m, rad]."""
    sd: Array = field(default_factory=lambda: np.zeros((0, 3)))
    """(b, 3) their standard deviations."""

    def and_one(self, before: int, poses: Array, covariance: Array) -> Bridges:
        """Return them with one more, between two poses (2, 3); the covariance is the later one's.

        Args:
            before: the last picture before it.
            poses: of that picture and of the next one that was kept.
            covariance: (3, 3) of the latter.
        """
        (x, y, theta), after = poses
        c, s = np.cos(theta), np.sin(theta)
        dx, dy = after[0] - x, after[1] - y
        step = np.array([c * dx + s * dy, -s * dx + c * dy, wrap_angle(after[2] - theta)])
        return Bridges(
            np.append(self.before, before),
            np.vstack([self.steps, step]),
            np.vstack([self.sd, BRIDGE_SD + np.sqrt(np.diag(covariance))]),
        )


@dataclass(frozen=True, eq=False)
class SeenBefore:
    """The pictures of a drive that its map was adjusted to."""

    poses: Array
    """(k, 3) of the robot [m, m, rad]."""
    stamps: Array
    """(k,) [s]"""
    seen: NDArray[np.intp]
    """(k,) how many edges each shows."""
    lying: NDArray[np.intp]
    """(k,) how many of them lie on strokes."""

    def passes(self, followed: Followed, begin_stamp: float) -> int:
        """Return how often the robot was where new pictures were taken; 0 if they show more.

        Args:
            followed: the new pictures; what counts is the place where it was least often.
            begin_stamp: of the first of them [s].
        """
        earlier = self.stamps < begin_stamp - PASS_S
        share = self.lying / np.maximum(1, self.seen)
        least, seen, lying = PASSES, 0.0, 0.0
        for pose, edges in zip(followed.poses, followed.seen, strict=True):
            near = np.hypot(*(self.poses[:, :2] - pose[:2]).T) < NEAR
            near &= (np.abs(wrap_angle(self.poses[:, 2] - pose[2])) < NEAR_TURN) & earlier
            if not near.any():
                return 0
            least = min(least, 1 + int((np.diff(self.stamps[near]) > PASS_S).sum()))
            seen += float(np.median(self.seen[near]))
            lying += float(edges * np.median(share[near]))
        is_same = followed.lying.sum() >= EXPLAINED * lying
        return least if is_same and followed.seen.sum() >= LEAST_SEEN * seen else 0


def edges_of(log: DriveLog) -> NDArray[np.intp]:
    """Return how many edges each picture (k,) of a drive shows."""
    shown: NDArray[np.intp] = np.isfinite(log.pixels[:, :, 0]).sum(axis=1)
    return shown
