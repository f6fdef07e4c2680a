"""Decides when the camera rests: the robot stands, and the filter waits for nothing.

Half of what a standing robot costs is pictures: to draw them in a simulator, to scan them, and to
check that they still fit. Five a second are enough to see that it was moved, ten for a page.
"""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager

from robot.geometry import Pose2

STANDS_S = 1.0
"""The camera rests after the robot has stood for this time [s]: the filter has settled by then."""
STILL_M, STILL_RAD = 0.001, 0.0049
"""Motion by odometry below which the robot stands: more than a step of one wheel's encoder on a
Build HAT (0.25 mm, 0.0044 rad), which may go on and off, and less than what the filter waits for.
"""
PAGE_HZ = 30.0
"""Ticks a second that a page needs: as many as there are pictures."""
RESTING_PERIOD, WATCHED_PERIOD = 0.2, 0.1
"""Time between two pictures of a camera that rests, and between readings [s]; the other while pages
look. Half of the first: it costs 0.7 % of a core more; twice: who is moved claims its place for 0.5
instead of 0.3 s. Half of the other: with a browser 48 % of a core instead of 35; twice: 19."""
VISIT_S = 2.0
"""Who asked for one picture or state is taken to look for this time [s], as most ask again."""


class Audience:
    """Those who look at what the robot sees; any thread may join and leave.

    Whoever makes an engine looks, until ``leave``: tests, evaluations and notebooks call ``step``.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._rates = [math.inf]
        self._visited = -math.inf

    @property
    def rate(self) -> float:
        """Ticks a second that are needed, besides those with a new picture; 0: nobody looks."""
        visit = PAGE_HZ if time.monotonic() - self._visited < VISIT_S else 0.0
        return max((*self._rates, visit))

    def visit(self) -> None:
        """Look for a moment."""
        self._visited = time.monotonic()

    def join(self, rate: float = math.inf) -> None:
        """Count one more, who needs so many ticks a second; by default each tick."""
        with self._lock:
            self._rates = [*self._rates, rate]

    def leave(self, rate: float = math.inf) -> None:
        """Count one less, of those who joined with this rate."""
        with self._lock:
            rates = self._rates.copy()
            rates.remove(rate)
            self._rates = rates

    @contextmanager
    def joined(self, rate: float = math.inf) -> Iterator[None]:
        """Look until the block ends."""
        self.join(rate)
        try:
            yield
        finally:
            self.leave(rate)


class Standstill:
    """Since when the robot stands, by odometry."""

    def __init__(self) -> None:
        self._pose: Pose2 | None = None
        self._since = -math.inf

    def seconds(self, odom_from_robot: Pose2, stamp: float) -> float:
        """Return how long the robot has stood at a stamp [s]; poses come in their order."""
        pose = self._pose
        if (
            pose is None
            or stamp < self._since
            or pose.distance_to(odom_from_robot) > STILL_M
            or abs(pose.turn_to(odom_from_robot)) > STILL_RAD
        ):
            self._pose, self._since = odom_from_robot, stamp
        return stamp - self._since
