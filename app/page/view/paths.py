"""Paths for drawing: past positions that are far enough apart."""

from __future__ import annotations

from collections import deque

import numpy as np

from app.page.thresholds import LONGEST_STEP_M
from robot.geometry import Array, Pose2

STEP_M = 0.01
LONGEST = 400


class Path:
    """The last positions of one moving thing."""

    def __init__(self) -> None:
        self._points: deque[tuple[float, float]] = deque(maxlen=LONGEST)
        self._breaks: deque[bool] = deque(maxlen=LONGEST)

    def add(self, pose: Pose2 | None) -> None:
        """Add a pose, if it is known and far enough from the last."""
        if pose is None:
            return
        if self._points:
            last_x, last_y = self._points[-1]
            way = Pose2(last_x, last_y).distance_to(pose)
            if way < STEP_M:
                return
            self._breaks.append(way > LONGEST_STEP_M)
        else:
            self._breaks.append(True)
        self._points.append((pose.x, pose.y))

    def segments(self, *, every: int = 1) -> Array:
        """Lines (n, 2, 2) [m] between positions; ``every=2`` drops each second one (dashed)."""
        points = np.array(self._points).reshape(-1, 2)
        joined = ~np.array(self._breaks, dtype=bool)[1:]
        lines = np.stack([points[:-1], points[1:]], axis=1) if len(points) else np.empty((0, 2, 2))
        kept: Array = lines[joined][::every]
        return kept
