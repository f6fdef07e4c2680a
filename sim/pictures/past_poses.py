"""Recent poses of a simulated robot, since a picture shows the past."""

from __future__ import annotations

from collections import deque

from robot.geometry import Pose2, Twist2, interpolate

HISTORY = 1.2
"""How long true poses are kept for frames that are not yet delivered [s]: the longest delay, half
of the longest exposure and half of a readout."""


class PastPoses:
    """True poses and twists in the map, by their stamps [s]."""

    def __init__(self) -> None:
        self._past: deque[tuple[float, Pose2, Twist2]] = deque()

    def remember(self, stamp: float, pose: Pose2, twist: Twist2) -> None:
        """Add a pose and a twist; stamps must increase."""
        self._past.append((stamp, pose, twist))
        while self._past[0][0] < stamp - HISTORY:
            self._past.popleft()

    def forget(self) -> None:
        """Remove all poses: the robot was placed elsewhere, so they must not be interpolated."""
        self._past.clear()

    def at(self, stamp: float) -> tuple[Pose2, Twist2]:
        """Return the true pose at a stamp, interpolated, and the twist of the next sample.

        Outside the kept time, these are the nearest pose and twist.

        Raises:
            IndexError: no pose has been added.
        """
        start = self._past[0]
        for end in self._past:
            if end[0] >= stamp:
                span = end[0] - start[0]
                part = (stamp - start[0]) / span if span > 0 else 0.0
                return interpolate(start[1], end[1], min(max(part, 0.0), 1.0)), end[2]
            start = end
        return start[1], start[2]
