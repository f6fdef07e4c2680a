"""The robot's way by odometry: what no robot can have driven is left out or bridged."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from robot.geometry import Array, Pose2, interpolate, wrap_angle

WIDEST = 2.0
"""Longest time between two poses over which to interpolate [s]."""
PAST_END = 0.1
"""For this long before the first pose and after the last, the robot is taken to stand there [s]."""
FARTHEST_M = 1e8
"""Coordinates beyond this are none: it is more than the way round the earth."""
FASTEST = 10.0
"""A pose is absurd if it takes so many times the fastest usual speed of the bag to come there."""
USUAL_SHARE = 0.95
"""The fastest usual speed is not exceeded in this share of the steps."""
LEAST_SPEEDS = 3.0, 6.0
"""Speeds that are possible for all robots [m/s, rad/s]."""
MOST_SPEEDS = 100.0, 100.0
"""Speeds that are possible for none [m/s, rad/s]."""
SLACK = 0.05, 0.05
"""Error of odometry that is no jump [m, rad]."""
EXCURSION = 10
"""If so many poses in a row are elsewhere, the odometry itself was set elsewhere."""
FEWEST = 3
"""Fewer poses than this, before all others and elsewhere, are absurd."""

Speeds = tuple[float, float]
"""[m/s, rad/s]"""


@dataclass(frozen=True)
class OdometryTrack:
    """The poses of the robot in the odom frame, at rising stamps."""

    stamps: list[float]
    poses: list[Pose2]
    absurd: int = 0
    """Number of poses that were left out, as no robot can have been there."""
    jumps: tuple[tuple[float, float], ...] = ()
    """When odometry was set elsewhere [s], and how far [m]; what follows is moved back."""

    @classmethod
    def of(cls, stamps: Sequence[float], poses: Sequence[Pose2]) -> OdometryTrack:
        """Make a track of poses at rising stamps."""
        places = [
            (stamp, pose) for stamp, pose in zip(stamps, poses, strict=True) if _is_place(pose)
        ]
        absurd = len(poses) - len(places)
        limits = _limits(places)
        way: list[tuple[float, Pose2]] = []
        moved = Pose2()
        jumps: list[tuple[float, float]] = []
        for index, (stamp, pose) in enumerate(places):
            placed = moved @ pose
            if not way or _reached(way[-1], (stamp, placed), limits):
                way.append((stamp, placed))
                continue
            if not _is_set_there(places[index : index + EXCURSION], way[-1], moved, limits):
                absurd += 1
            elif len(way) < FEWEST:  # it began elsewhere
                absurd += len(way)
                way = [(stamp, pose)]
            else:
                last = way[-1][1]
                jumps.append((stamp, last.distance_to(placed)))
                moved = last @ pose.inverse()
                way.append((stamp, last))
        return cls([stamp for stamp, _ in way], [pose for _, pose in way], absurd, tuple(jumps))

    def at(self, stamp: float) -> Pose2 | None:
        """Return the pose at a stamp, interpolated; None if it is not known."""
        stamps, poses = self.stamps, self.poses
        after = bisect_left(stamps, stamp)
        if after < len(stamps) and stamps[after] == stamp:
            return poses[after]
        if after in (0, len(stamps)):
            if not stamps:
                return None
            end = -1 if after else 0
            return poses[end] if abs(stamps[end] - stamp) <= PAST_END else None
        low, high = stamps[after - 1], stamps[after]
        if high - low > WIDEST:
            return None
        return interpolate(poses[after - 1], poses[after], (stamp - low) / (high - low))


def _is_set_there(
    places: Sequence[tuple[float, Pose2]], last: tuple[float, Pose2], moved: Pose2, limits: Speeds
) -> bool:
    """Whether odometry goes on from a place elsewhere, and does not return to the last pose."""
    settled = len(places) >= FEWEST
    for before, (stamp, pose) in pairwise(places):
        if not _reached(before, (stamp, pose), limits):
            if _reached(last, (stamp, moved @ pose), limits):
                return False
            settled = False
    return settled


def _is_place(pose: Pose2) -> bool:
    return pose.is_finite() and max(abs(pose.x), abs(pose.y)) <= FARTHEST_M


def _limits(places: Sequence[tuple[float, Pose2]]) -> Speeds:
    """Return the speeds above which a pose is absurd."""
    if len(places) < 2:
        return LEAST_SPEEDS
    stamps = np.array([stamp for stamp, _ in places])
    steps = np.diff([pose.to_array() for _, pose in places], axis=0)
    driven, turned = np.hypot(steps[:, 0], steps[:, 1]), np.abs(wrap_angle(steps[:, 2]))
    metres, radians = (
        _limit(amounts / np.diff(stamps), least, most)
        for amounts, least, most in zip((driven, turned), LEAST_SPEEDS, MOST_SPEEDS, strict=True)
    )
    return metres, radians


def _limit(speeds: Array, least: float, most: float) -> float:
    possible = speeds[speeds <= most]
    usual = float(np.quantile(possible, USUAL_SHARE)) if len(possible) else 0.0
    return max(FASTEST * usual, least)


def _reached(start: tuple[float, Pose2], end: tuple[float, Pose2], limits: Speeds) -> bool:
    """Whether a robot can have come from one pose to another in the time between."""
    (begin, pose), (finish, other) = start, end
    metres, radians = (limit * (finish - begin) for limit in limits)
    near = pose.distance_to(other) <= metres + SLACK[0]
    return near and abs(pose.turn_to(other)) <= radians + SLACK[1]
