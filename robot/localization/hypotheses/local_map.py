"""A short map: the scans of the last moments, laid together by odometry alone."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass

import numpy as np

from robot.geometry import Array, Pose2
from robot.localization.hypotheses.rescoring import ScanHistory
from robot.localization.hypothesis_parameters import HypothesisParameters
from robot.localization.models.motion_models import MotionModel
from robot.localization.rays import rays_of
from robot.scan import Scan, evenly


@dataclass(frozen=True, slots=True)
class _Kept:
    """A scan of the map."""

    pose: Pose2
    """Of the robot."""
    scan: Scan
    hits: int
    """Rays that returned something."""
    seeing: int
    """Rays that see anything."""

    @classmethod
    def at(cls, pose: Pose2, scan: Scan) -> _Kept:
        rays = rays_of(scan, len(scan.ranges))
        seeing = rays[~np.isnan(rays[:, 4])]
        return cls(pose, scan, int(np.isfinite(seeing[:, 3]).sum()), len(seeing))


class LocalMap:
    """The scans of the last stretch of the way, and how the robot moved between them."""

    def __init__(self, spacing_xy: float, spacing_theta: float, most: int) -> None:
        self._spacing = spacing_xy, spacing_theta
        self._most = most
        self._robot = Pose2()
        """In a frame of its own, that starts anywhere."""
        self._scans: deque[_Kept] = deque(maxlen=most)
        self.whole = True
        """Whether it goes back to where it began, or began anew: no scan was given up since."""

    @classmethod
    def of(cls, parameters: HypothesisParameters) -> LocalMap:
        """An empty one, as the parameters want it."""
        return cls(parameters.map_step_xy, parameters.map_step_theta, parameters.map_scans)

    def __len__(self) -> int:
        return len(self._scans)

    def begin_anew(self, keep: int) -> None:
        """Keep only the newest scans: the robot may have been carried before."""
        self.whole = True
        while len(self._scans) > keep:
            self._scans.popleft()

    def move(self, moved: Pose2) -> None:
        """Follow a step by odometry."""
        self._robot = self._robot @ moved

    def add(self, scan: Scan) -> bool:
        """Keep a scan if the robot has moved on since the last that was kept."""
        if self._scans:
            since = self._scans[-1].pose.inverse() @ self._robot
            near = math.hypot(since.x, since.y) < self._spacing[0]
            if near and abs(since.theta) < self._spacing[1]:
                return False
        self.whole &= len(self._scans) < self._most
        self._scans.append(_Kept.at(self._robot, scan))
        return True

    def rays(self, scans: int, beams: int) -> Array:
        """At most so many rays of so many scans (n, 7), as ``rays_of`` has them, from the newest.

        They are seen from where the robot was at the newest kept scan.
        """
        last = self._scans[-1].pose.inverse()
        some = evenly(len(self._scans), scans)
        return np.concatenate(
            [_seen_from(last @ self._scans[i].pose, self._scans[i].scan, beams) for i in some]
        )

    def past(self, scans: int, beams: int, motion: MotionModel) -> ScanHistory:
        """At most so many of the scans, the newest first, with so many rays each."""
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
        """Scans until it is full."""
        return self._most - len(self._scans)

    @property
    def since(self) -> Pose2:
        """How the robot moved since the newest kept scan."""
        return self._scans[-1].pose.inverse() @ self._robot

    @property
    def hit_share(self) -> float:
        """Share of the rays that returned something, of those that see anything."""
        seeing = sum(kept.seeing for kept in self._scans)
        return sum(kept.hits for kept in self._scans) / seeing if seeing else 0.0


def _seen_from(here_from_robot: Pose2, scan: Scan, beams: int) -> Array:
    rays = rays_of(scan, beams)
    rays[:, :2] = here_from_robot.apply(rays[:, :2])
    rays[:, 2] += here_from_robot.theta
    return rays


def _stacked(scans: list[Array]) -> Array:
    """Rays of several scans (m, k, 7), filled up with rays that see nowhere."""
    most = max(len(rays) for rays in scans)
    stacked = np.full((len(scans), most, 7), np.nan)
    for place, rays in enumerate(scans):
        stacked[place, : len(rays)] = rays
    return stacked
