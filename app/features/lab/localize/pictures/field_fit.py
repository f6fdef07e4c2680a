"""FieldFit, the share of the edges in the last pictures that lie on the field's where they should.

A filter judges its places by its own settings, and one that follows a single place by none. This
asks neither: whatever filter says where the robot is, tape that it sees there has to be drawn.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import replace

import numpy as np
from scipy.spatial import cKDTree

from robot.fields.edges import sample
from robot.fields.field import Field
from robot.geometry import Pose2
from robot.localization.estimate import BOUNDED, Integrity, State
from robot.scan import Scan

STEP_M = 0.004
"""Step along the field's edges."""
NEAR_M = 0.03
"""An edge that is seen nearer to a drawn one lies on it: tape laid by hand is some centimetres off.
On the lane's sequence, the least mean is 79 % at the right place, and the highest 61 % at six wrong
ones; within 10 mm they are 42 and 49 %, within 20 mm 72 and 59 %."""
WINDOW_S = 2.0
"""The mean is that of pictures of this time [s]: single ones with reflections or blur have 12 %."""
FEWEST = 3
"""... and of at least so many pictures, however long ago; before, nothing is said."""
FEWEST_EDGES = 10
"""A picture with fewer edges tells nothing."""
LOST = 0.65
"""The robot is lost where a smaller share lies on the field. On the lane's sequence, 20 of 22
pictures are told lost from each of six wrong starts, and none from the right one, with either
filter; half of it would tell three of the six late or never, and more than 0.79 the right one."""


class FieldFit:
    """Checks places by what the pictures show."""

    def __init__(self, field: Field) -> None:
        """Take a field of tape, before any picture."""
        points, self._normals = sample(field.edges, STEP_M)
        self._edges = cKDTree(points)
        self._shares: deque[tuple[float, float]] = deque()

    @property
    def share(self) -> float:
        """Mean share, 0 to 1, over the last pictures; nan before there are enough of them."""
        if len(self._shares) < FEWEST:
            return math.nan
        return float(np.mean([share for _, share in self._shares]))

    def observe(self, scan: Scan, pose: Pose2) -> None:
        """Take in the edges of a picture (``scan``), and the robot's pose in the map."""
        ends = scan.points()
        if len(ends) < FEWEST_EDGES:
            return
        distances, nearest = self._edges.query(pose.apply(ends))
        ways = scan.bearings[scan.hit] + scan.robot_from_scan.theta + pose.theta
        # A ray enters tape, so it comes from where the edge's normal points.
        across = self._normals[nearest]
        enters = across[:, 0] * np.cos(ways) + across[:, 1] * np.sin(ways) < 0
        share = np.count_nonzero((distances < NEAR_M) & enters) / len(ends)
        self._shares.append((scan.stamp, share))
        while len(self._shares) > FEWEST and self._shares[0][0] < scan.stamp - WINDOW_S:
            self._shares.popleft()

    def judged(self, claimed: Integrity) -> Integrity:
        """Return what may be claimed of a place, besides what the filter claims of it."""
        share = self.share
        if share < LOST:
            return Integrity(State.LOST, alerts=claimed.alerts)
        if math.isnan(share) and claimed.state in BOUNDED:
            return replace(claimed, state=State.APPROXIMATE)
        return claimed
