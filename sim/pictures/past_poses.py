"""Where a simulated robot was a moment ago: a picture shows the past."""

from __future__ import annotations

from collections import deque

from robot.geometry import Pose2, Twist2, interpolate

HISTORY = 1.2
"""How long true poses are kept for frames that are still under way [s]: the longest delay, half of
the longest exposure and half of a readout."""


class PastPoses:
    """True poses and twists in the map, by their stamps [s]."""

    def __init__(self) -> None:
        self._past: deque[tuple[float, Pose2, Twist2]] = deque()

    def remember(self, stamp: float, pose: Pose2, twist: Twist2) -> None:
        """Keep one more; stamps rise."""
        self._past.append((stamp, pose, twist))
        while self._past[0][0] < stamp - HISTORY:
            self._past.popleft()

    def forget(self) -> None:
        """The robot was put elsewhere: nothing lies between there and here."""
        self._past.clear()

    def at(self, stamp: float) -> tuple[Pose2, Twist2]:
        """True pose and twist at a moment that is still remembered; else at the nearest one.

        Raises:
            IndexError: nothing is remembered.
        """
        start = self._past[0]
        for end in self._past:
            if end[0] >= stamp:
                span = end[0] - start[0]
                part = (stamp - start[0]) / span if span > 0 else 0.0
                return interpolate(start[1], end[1], min(max(part, 0.0), 1.0)), end[2]
            start = end
        return start[1], start[2]
