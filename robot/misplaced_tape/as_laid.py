"""AsLaid: follows a robot on tape that lies beside its drawing, and corrects its scans by that."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from robot import ray_columns as column
from robot.geometry import Array, Pose2
from robot.misplaced_tape.laid_tracker import LaidTracker
from robot.misplaced_tape.search import RAYS, stands
from robot.scan import Scan, rays_of

GATE, GATE_BY_RANGE2 = 0.03, 0.05
"""A return so far from where it should be [m], and by so much more by its squared range [1/m], is
of something else, and is not corrected."""
LARGEST_SHIFT = 0.06
"""A ray that would see so much more or less of the drawing meets other tape there [m]."""
EDGE = 0.03
"""So far before tape that the drawing does not have there a ray's sight ends [m]."""
FADES = 0.97
"""Counts of rays fade by this with each scan."""
LOST_SHARE, LEAST_RAYS = 0.3, 40
"""The place is lost if so large a share of the last rays does not fit; fewer tell nothing."""
TORN, TORN_SCANS = 4.5, 5.0
"""It is lost, too, if so many of the last steps contradict odometry by so many standard deviations:
the robot has been moved, or its wheels slip, and the tape would be blamed."""
AT_ONCE = np.array([0.002, 0.002, 0.005])
"""By so much one scan may move the place at once; more of it follows scan by scan, because the
robot has not been moved, but its floor is known better [m, m, rad]."""
LAG_FADES = 0.9
"""What is left of it with each scan."""
LOST_M = 0.1
"""It is also lost if its standard deviation is larger [m]."""
SHOWN_SDS = 2.0
"""A scale is told if it differs from one by so many standard deviations."""


@dataclass(frozen=True)
class Laid:
    """How tape lies that lies beside its drawing, as far as it was seen."""

    scale: float | None
    """Size of the floor by that of the drawing; None if it cannot be told from 1."""
    aside: float
    """How far its tape lies aside where that is most [m], besides the scale."""
    x: float
    """Where this is, in the drawing [m]."""
    y: float


class AsLaid:
    """The place of a robot while all tape lies a little beside its drawing."""

    def __init__(self, tracker: LaidTracker, odometry: Pose2) -> None:
        """Go on from where a search has followed the robot to, at an odometry pose."""
        self._tracker, self._odometry = tracker, odometry
        self._fits = self._misses = self._torn = 0.0
        self._lag = np.zeros(3)
        """How far scans are corrected to a place behind the one that is followed [m, m, rad]."""

    def restart(self, pose: Pose2, covariance: Array, odometry: Pose2) -> None:
        """Go on at a place that is known again, by the tape as it was learnt."""
        self._tracker.restart(pose, covariance)
        self._odometry, self._lag = odometry, np.zeros(3)
        self._fits = self._misses = self._torn = 0.0

    @property
    def finding(self) -> Laid:
        """How the tape lies."""
        tape, offsets = self._tracker.tape, self._tracker.offsets
        sd = float(np.sqrt(self._tracker.offsets_covariance[-1, -1]))
        scale, aside = float(offsets[-1]), np.hypot(*tape.shifts(offsets).T)
        most = int(np.argmax(aside))
        x, y = tape.centres[most].tolist()
        return Laid(1 + scale if abs(scale) > SHOWN_SDS * sd else None, float(aside[most]), x, y)

    def clear(self, scan: Scan, odometry: Pose2) -> Scan:
        """Follow the robot by one more scan, and return it as tape as drawn would be seen."""
        moved = self._odometry.inverse() @ odometry
        if not stands(moved):
            self._odometry = odometry
            self._step(moved, scan)
        every = rays_of(scan, len(scan.ranges))
        tracker, seen = self._tracker, every[:, column.RANGE]
        laid = tracker.expected(every)
        drawn = tracker.drawn(self._shown(tracker.pose), every)
        with np.errstate(invalid="ignore"):
            shift = drawn - laid
            own = np.abs(seen - laid) < GATE + GATE_BY_RANGE2 * laid**2
        alike = np.isfinite(shift) & (np.abs(shift) < LARGEST_SHIFT)
        own &= alike
        ranges = np.where(own, seen + np.where(own, shift, 0.0), seen)
        # Where only one of both has tape, nothing can be said.
        unlike = ~alike & (np.isfinite(laid) | np.isfinite(drawn))
        ends = np.where(unlike, np.minimum(laid, drawn) - EDGE, np.inf)
        return replace(scan, ranges=ranges).until(ends)

    @property
    def is_lost(self) -> bool:
        """Whether the robot is no longer where it is followed."""
        looked = self._fits + self._misses
        odd = looked > LEAST_RAYS and self._misses > LOST_SHARE * looked
        torn = self._torn > TORN_SCANS or not self.is_plausible
        return odd or torn or self.width > LOST_M

    @property
    def is_plausible(self) -> bool:
        """Whether the tape may lie as it was learnt."""
        return self._tracker.is_plausible

    @property
    def width(self) -> float:
        """Largest standard deviation of the place [m]."""
        return float(np.sqrt(np.linalg.eigvalsh(self._tracker.covariance[:2, :2])[-1]))

    def place(self, odometry: Pose2) -> tuple[Pose2, Array]:
        """Return where the robot is at an odometry pose, and its covariance (3, 3)."""
        moved = self._odometry.inverse() @ odometry
        return self._tracker.pose @ moved, self._tracker.covariance

    @property
    def unsure(self) -> Array:
        """By how much corrected scans may lead elsewhere: a covariance (3, 3) [m, m, rad]."""
        return self._tracker.covariance + np.outer(self._lag, self._lag)

    def _shown(self, pose: Pose2) -> Pose2:
        dx, dy, turn = self._lag.tolist()
        return Pose2(pose.x - dx, pose.y - dy, pose.theta - turn)

    def _step(self, moved: Pose2, scan: Scan) -> None:
        tracker = self._tracker
        predicted = tracker.pose @ moved
        tracker.step(moved, rays_of(scan, RAYS))
        pose = tracker.pose
        change = np.array([pose.x - predicted.x, pose.y - predicted.y, predicted.turn_to(pose)])
        self._lag = LAG_FADES * self._lag + change - np.clip(change, -AT_ONCE, AT_ONCE)
        self._fits = FADES * self._fits + tracker.fits
        self._misses = FADES * self._misses + tracker.misses
        self._torn = FADES * self._torn + (tracker.leap > TORN)
