"""A short map: the last scans, joined by odometry alone."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass

import numpy as np

from robot import ray_columns as column
from robot.geometry import Array, Pose2
from robot.localization.hypotheses.rescoring import ScanHistory
from robot.localization.models.motion_models import MotionModel
from robot.localization.parameters import HypothesisParameters
from robot.scan import Scan, evenly, rays_of


@dataclass(frozen=True, slots=True)
class _Kept:
    """A scan of the map."""

    pose: Pose2
    """Pose of the robot in the short map."""
    scan: Scan
    hits: int
    """Rays that returned something."""
    seeing: int
    """Rays that see anything."""

    @classmethod
    def at(cls, pose: Pose2, scan: Scan) -> _Kept:
        rays = rays_of(scan, len(scan.ranges))
        seeing = ~np.isnan(rays[:, column.NEAR])
        hits = int(np.count_nonzero(seeing & np.isfinite(rays[:, column.RANGE])))
        return cls(pose, scan, hits, int(np.count_nonzero(seeing)))


class LocalMap:
    """The scans of the last stretch of the path, and how the robot moved between them."""

    def __init__(self, spacing_xy: float, spacing_theta: float, most: int) -> None:
        self._spacing = spacing_xy, spacing_theta
        self._most = most
        self._robot = Pose2()
        """Current pose of the robot in the short map's own frame, with an arbitrary origin."""
        self._scans: deque[_Kept] = deque(maxlen=most)
        self.whole = True
        """Whether it goes back to its start or restart: no scan was dropped since then."""

    @classmethod
    def of(cls, parameters: HypothesisParameters) -> LocalMap:
        """Return an empty short map for the parameters."""
        return cls(parameters.map_step_xy, parameters.map_step_theta, parameters.map_scans)

    def __len__(self) -> int:
        return len(self._scans)

    def begin_anew(self, keep: int) -> None:
        """Keep only the newest scans: the robot may have been carried off before them."""
        self.whole = True
        while len(self._scans) > keep:
            self._scans.popleft()

    def move(self, moved: Pose2) -> None:
        """Move the robot by a step of odometry."""
        self._robot = self._robot @ moved

    def add(self, scan: Scan) -> bool:
        """Keep a scan if the robot has moved since the last kept one; return whether it is kept."""
        if self._scans:
            since = self._scans[-1].pose.inverse() @ self._robot
            near = math.hypot(since.x, since.y) < self._spacing[0]
            if near and abs(since.theta) < self._spacing[1]:
                return False
        self.whole &= len(self._scans) < self._most
        self._scans.append(_Kept.at(self._robot, scan))
        return True

    def rays(self, scans: int, beams: int) -> Array:
        """Return at most ``beams`` rays of each of at most ``scans`` scans, as ``rays_of`` (n, 9).

        They are seen from the robot's pose at the newest kept scan.
        """
        last = self._scans[-1].pose.inverse()
        some = evenly(len(self._scans), scans)
        return np.concatenate(
            [_seen_from(last @ self._scans[i].pose, self._scans[i].scan, beams) for i in some]
        )

    def past(self, scans: int, beams: int, motion: MotionModel) -> ScanHistory:
        """Return at most ``scans`` scans, the newest first, with at most ``beams`` rays each."""
        some = [self._scans[-1 - i] for i in evenly(len(self._scans), scans)]
        before = [some[0], *some[:-1]]
        moves = [
            motion.moments(a.pose.inverse() @ b.pose) for a, b in zip(before, some, strict=True)
        ]
        return ScanHistory(
            np.array([step.to_array() for step, _ in moves]),
            np.array([noise for _, noise in moves]),
            _stacked([rays_of(kept.scan, beams) for kept in some]),
        )

    @property
    def lacking(self) -> int:
        """Number of scans until the short map is full."""
        return self._most - len(self._scans)

    @property
    def since(self) -> Pose2:
        """How the robot moved since the newest kept scan."""
        return self._scans[-1].pose.inverse() @ self._robot

    @property
    def hit_share(self) -> float:
        """Share of rays that returned something, among those that see anything."""
        seeing = sum(kept.seeing for kept in self._scans)
        return sum(kept.hits for kept in self._scans) / seeing if seeing else 0.0


def _seen_from(here_from_robot: Pose2, scan: Scan, beams: int) -> Array:
    rays = rays_of(scan, beams)
    rays[:, :2] = here_from_robot.apply(rays[:, :2])
    rays[:, column.DIRECTION] += here_from_robot.theta
    return rays


def _stacked(scans: list[Array]) -> Array:
    """Stack the rays of several scans (m, k, 9); fill up with rays that see nowhere."""
    most = max(len(rays) for rays in scans)
    stacked = np.full((len(scans), most, 9), np.nan)
    for place, rays in enumerate(scans):
        stacked[place, : len(rays)] = rays
    return stacked
