"""Odometry as poses by stamp, interpolated between them."""

from __future__ import annotations

import math
from bisect import bisect_left
from collections import deque

from robot.geometry import Pose2, interpolate

KEPT = 2000
"""Number of poses that are remembered: 10 s at 200 Hz."""
WIDEST = 2.0
"""Longest time between two poses over which to interpolate [s]."""
PAST_END = 0.1
"""For this long before the first pose and after the last, the robot is taken to stand there [s]."""


class PoseTrack:
    """The last poses of the robot in the odom frame."""

    def __init__(self) -> None:
        self._stamps: deque[float] = deque(maxlen=KEPT)
        self._poses: deque[Pose2] = deque(maxlen=KEPT)
        self.refused = 0
        """Number of poses that were not finite, or not after the previous one."""

    @property
    def last(self) -> float:
        """The newest stamp [s]; -inf if there is none."""
        return self._stamps[-1] if self._stamps else -math.inf

    def add(self, stamp: float, pose: Pose2 | None) -> None:
        """Add a pose; an unusable pose is only counted."""
        if pose is None or not pose.is_finite() or not stamp > self.last:
            self.refused += 1
            return
        self._stamps.append(stamp)
        self._poses.append(pose)

    def at(self, stamp: float) -> Pose2 | None:
        """Return the pose at a stamp, interpolated; None if it is not known."""
        after = bisect_left(self._stamps, stamp)
        if after < len(self._stamps) and self._stamps[after] == stamp:
            return self._poses[after]
        if after in (0, len(self._stamps)):
            if not self._stamps:
                return None
            end = -1 if after else 0
            near = abs(self._stamps[end] - stamp) <= PAST_END
            return self._poses[end] if near else None
        low, high = self._stamps[after - 1], self._stamps[after]
        if high - low > WIDEST:
            return None
        return interpolate(self._poses[after - 1], self._poses[after], (stamp - low) / (high - low))
