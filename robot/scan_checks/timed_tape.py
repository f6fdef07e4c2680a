"""Timed tape: what a picture shows of the tape, and where the robot was when it was taken.

A picture may have been taken earlier than its stamp says. Then its tape lies where it was then:
moved by what the robot has driven since.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

import numpy as np

from robot.geometry import Array, Pose2, Twist2, interpolate
from robot.scan_checks.overlay import FEWEST, misfit

LATEST, STEP = 0.2, 0.01
"""Largest change of lateness that is looked for, and the steps of the search [s]."""
CHANGES = np.arange(-LATEST, LATEST + STEP / 2, STEP)
"""(41,) the changes that are looked for [s]."""


class RecentPath:
    """Odometry at the stamps of the last pictures."""

    def __init__(self) -> None:
        """Begin with no picture."""
        self._poses: deque[tuple[float, Pose2]] = deque()

    def clear(self) -> None:
        """Forget the way so far."""
        self._poses.clear()

    def add(self, stamp: float, odometry: Pose2) -> tuple[tuple[float, Pose2], ...]:
        """Add a picture; return stamps [s] and odometry of this one and of those before it."""
        self._poses.append((stamp, odometry))
        while stamp - self._poses[0][0] > 2 * LATEST:
            self._poses.popleft()
        return tuple(self._poses)


@dataclass(frozen=True, slots=True, eq=False)
class TimedTape:
    """The tape in a picture, and the way that the robot had driven by its stamp."""

    path: tuple[tuple[float, Pose2], ...]
    """Stamps [s] and odometry of the pictures before, and of this one."""
    twist: Twist2
    """How the robot drove then, by odometry."""
    points: Array
    """(n, 2) [m], in the robot's frame when the picture was taken."""
    late: float = 0.0
    """How much earlier it was taken than its stamp says [s]."""

    @property
    def stamp(self) -> float:
        """When the picture was taken, as it says [s]."""
        return self.path[-1][0]

    @property
    def odometry(self) -> Pose2:
        """Odometry at its stamp."""
        return self.path[-1][1]

    def taken_at(self, late: float) -> Pose2:
        """Return where odometry was when the picture was taken, if it was as late as this [s]."""
        stamp, after = self.stamp - late, self.path[-1]
        for before in reversed(self.path[:-1]) if late > 0 else ():
            if before[0] <= stamp:
                return interpolate(
                    before[1], after[1], (stamp - before[0]) / (after[0] - before[0])
                )
            after = before
        return after[1] @ self.twist.integrate(stamp - after[0])

    def can_be_laid_on(self, before: TimedTape) -> bool:
        """Return whether both show enough tape."""
        return min(len(self.points), len(before.points)) >= FEWEST

    def error(self, before: TimedTape, late: float) -> float:
        """Return how far this tape is off that before, if its picture is as late as this [m]."""
        motion = before.taken_at(before.late).inverse() @ self.taken_at(late)
        return misfit(before.points, motion, self.points)

    def search(self, before: TimedTape) -> tuple[float, float]:
        """Return the lateness [s] that lays this tape on that before, and its error then [m]."""
        tried = before.late + CHANGES
        errors = [self.error(before, late) for late in tried.tolist()]
        best = int(np.argmin(errors))
        return float(tried[best]), errors[best]
