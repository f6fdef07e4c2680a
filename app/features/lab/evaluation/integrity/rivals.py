"""Find rivals: poses at the first scan of a way that could be mistaken for the true pose."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from app.features.lab.evaluation.drives import Drive
from app.features.lab.evaluation.experiment import OFFSET
from app.features.lab.evaluation.integrity.claims import Claims, entries_over
from app.features.lab.evaluation.integrity.measures import right
from app.settings.config import Config
from robot.fields.field import Field
from robot.geometry import Array, Pose2
from robot.localization.filter import Setup
from robot.localization.hypotheses.local_map import LocalMap
from robot.localization.hypotheses.place_search import PlaceSearch
from robot.scan import Scan, rays_of

BEAMS = 60
"""Number of rays used of each scan."""
SEARCHES = (1.0, 3.0)
"""Times after the first scan when the field is searched for places that fit the scans [s]."""
APART_XY, APART_THETA = 0.08, math.radians(12)
"""Rivals closer than this are the same rival [m], [rad]."""
MOST_CLAIMED = 20
"""Largest number of rivals from the filter's claims; those claimed longest count."""


@dataclass(frozen=True, eq=False)
class DriveSegment:
    """A part of a drive for the oracle: every second scan, as errors of neighbours correlate."""

    stamps: Array
    """(m,) [s]"""
    truths: tuple[Pose2, ...]
    scans: tuple[Scan, ...]

    @classmethod
    def since(cls, drive: Drive, stamp: float) -> DriveSegment:
        """Return the part of a drive from a stamp [s] to the end."""
        scans = [tick.scan for tick in drive.ticks if tick.scan is not None]
        some = [scan for scan in scans if scan.stamp > stamp + 1e-6][::2]
        truths = tuple(drive.truth_at(scan.stamp) for scan in some)
        return cls(np.array([scan.stamp for scan in some]), truths, tuple(some))

    def rays(self, place: int) -> Array:
        """Return the rays of a scan (n, 9), as ``rays_of`` makes them."""
        return rays_of(self.scans[place], BEAMS)

    def step(self, place: int) -> Pose2:
        """Return the robot's true motion from the previous scan to a scan."""
        if place == 0:
            return Pose2()
        return self.truths[place - 1].inverse() @ self.truths[place]

    def at_first(self, pose: Pose2, truth: Pose2) -> Pose2:
        """Take a pose, supposed while the robot was at ``truth``, back to the first scan."""
        return pose @ (truth.inverse() @ self.truths[0])


def setup_over(field: Field, config: Config) -> Setup:
    """Return the models that the program uses to search for places."""
    return Setup.of_field(field, config.localization, entries_over(field, config))


def rivals_of(
    way: DriveSegment, claims: Claims, start: str, before: Pose2 | None, setup: Setup
) -> list[Pose2]:
    """Return all rivals at the first scan of a way, each once, none at the true place.

    Args:
        way: the part of the drive after the start or the carry.
        claims: the filter's claims on the drive.
        start: what the filter knows. With a wrong start pose only near places are possible: the
            rivals are this pose and those that the filter claimed.
        before: the pose before the robot was carried off.
    """
    current = way.truths[0]
    claimed = _claimed(way, claims)
    if start == "told-wrong":
        dx, dy, turn = OFFSET
        rivals = [Pose2(current.x + dx, current.y + dy, current.theta + turn), *claimed]
    else:
        rivals = [*field_rivals(way, setup), *claimed]
    if before is not None:
        rivals.append(before)
    return distinct(rivals, current)


def field_rivals(way: DriveSegment, setup: Setup) -> list[Pose2]:
    """Return the rivals from the field alone: turned true poses, and what a search finds."""
    current = way.truths[0]
    return distinct([*_turned(current, setup.field), *_searched(way, setup)], current)


def distinct(rivals: list[Pose2], pose2: Pose2) -> list[Pose2]:
    """Return the rivals, each once, without those at the true pose."""
    kept: list[Pose2] = []
    for rival in rivals:
        if not any(_alike(rival, other) for other in (pose2, *kept)):
            kept.append(rival)
    return kept


def _alike(pose2: Pose2, other: Pose2) -> bool:
    return pose2.distance_to(other) < APART_XY and abs(pose2.turn_to(other)) < APART_THETA


def _turned(pose: Pose2, field: Field) -> list[Pose2]:
    """Turn a pose by one, two and three quarter turns about the middle of the tape."""
    points = field.edges.reshape(-1, 2)
    middle = Pose2(*((points.min(axis=0) + points.max(axis=0)) / 2).tolist())
    seen = middle.inverse() @ pose
    return [middle @ Pose2(theta=quarter * math.pi / 2) @ seen for quarter in (1, 2, 3)]


def _searched(way: DriveSegment, setup: Setup) -> list[Pose2]:
    """Search the whole field at some moments, each time for poses that fit the way so far."""
    local = LocalMap.of(setup.hypotheses)
    left = [way.stamps[0] + seconds for seconds in SEARCHES]
    pose2s: list[Pose2] = []
    for index, scan in enumerate(way.scans):
        local.move(way.step(index))
        local.add(scan)
        if left and scan.stamp >= left[0]:
            left.pop(0)
            search = PlaceSearch(local, [], setup)
            while not search.advance():
                pass
            truth = way.truths[index]
            pose2s += [way.at_first(life.pose @ search.since, truth) for life in search.found]
    return pose2s


def _claimed(way: DriveSegment, claims: Claims) -> list[Pose2]:
    """Return the wrong estimates of the filter on the way; those held longest come first."""
    some = np.flatnonzero((claims.stamps >= way.stamps[0]) & ~right(claims))
    some = some[np.isfinite(claims.poses[some]).all(axis=1)]
    groups: list[tuple[Pose2, int]] = []
    for place in some:
        truth = Pose2(*claims.truth[place].tolist())
        pose = way.at_first(Pose2(*claims.poses[place].tolist()), truth)
        for index, (other, count) in enumerate(groups):
            if _alike(pose, other):
                groups[index] = other, count + 1
                break
        else:
            groups.append((pose, 1))
    groups.sort(key=lambda item: -item[1])
    return [pose for pose, _ in groups[:MOST_CLAIMED]]
