"""Places that could be mistaken for the true one, by where they are at the first scan of a way."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from app.lab.evaluation.drives import Drive
from app.lab.evaluation.experiment import OFFSET
from app.lab.evaluation.integrity.claims import Claims, entries_over
from app.lab.evaluation.integrity.measures import right
from app.settings.config import Config
from robot.fields.field import Field
from robot.geometry import Array, Pose2
from robot.localization.hypotheses.local_map import LocalMap
from robot.localization.hypotheses.place_search import PlaceSearch
from robot.localization.models.sensor_models import sensor_model
from robot.localization.rays import rays_of
from robot.localization.setup import Setup
from robot.scan import Scan

BEAMS = 60
"""Rays of a scan."""
SEARCHES = (1.0, 3.0)
"""So long after the first scan the field is searched for what looks like the way [s]."""
APART_XY, APART_THETA = 0.08, math.radians(12)
"""Rivals that are closer are one [m], [rad]."""
MOST_CLAIMED = 20
"""Of the places that were claimed, those that were claimed longest count."""


@dataclass(frozen=True)
class Way:
    """A part of a drive as the oracle sees it: every second scan, as neighbours err together."""

    stamps: Array
    """(m,) [s]"""
    truths: tuple[Pose2, ...]
    scans: tuple[Scan, ...]

    @classmethod
    def since(cls, drive: Drive, stamp: float) -> Way:
        """From a stamp [s] on to the end."""
        scans = [tick.scan for tick in drive.ticks if tick.scan is not None]
        some = [scan for scan in scans if scan.stamp > stamp + 1e-6][::2]
        truths = tuple(drive.truth_at(scan.stamp) for scan in some)
        return cls(np.array([scan.stamp for scan in some]), truths, tuple(some))

    def rays(self, place: int) -> Array:
        """Of a scan (n, 7), as ``rays_of`` makes them."""
        return rays_of(self.scans[place], BEAMS)

    def step(self, place: int) -> Pose2:
        """How the robot truly moved to a scan from the one before."""
        if place == 0:
            return Pose2()
        return self.truths[place - 1].inverse() @ self.truths[place]

    def at_first(self, pose: Pose2, truth: Pose2) -> Pose2:
        """A pose that was supposed where the robot truly was elsewhere, at the first scan."""
        return pose @ (truth.inverse() @ self.truths[0])


def setup_over(field: Field, config: Config) -> Setup:
    """The models by which the program looks for places."""
    parameters, entries = config.localization, entries_over(field, config)
    sensor = sensor_model(parameters.sensor, entries, field.edges)
    return Setup.of(field, entries, parameters.motion.model(), sensor, parameters)


def rivals_of(
    way: Way, claims: Claims, start: str, before: Pose2 | None, setup: Setup
) -> list[Pose2]:
    """All rivals at the first scan of a way, each once, none at the true place.

    Args:
        way: from the start or the carry on.
        claims: what the filter made of the drive.
        start: what was known. Told a place, be it wrong, only what is near can be meant.
        before: where the robot was before it was carried off.
        setup: how places are looked for.
    """
    current = way.truths[0]
    claimed = _claimed(way, claims)
    if start == "told-wrong":
        dx, dy, turn = OFFSET
        rivals = [Pose2(current.x + dx, current.y + dy, current.theta + turn), *claimed]
    else:
        rivals = [*lookalikes(way, setup), *claimed]
    if before is not None:
        rivals.append(before)
    return distinct(rivals, current)


def lookalikes(way: Way, setup: Setup) -> list[Pose2]:
    """Rivals that the field itself has, whatever a filter claims: turned and searched ones."""
    current = way.truths[0]
    return distinct([*_turned(current, setup.field), *_searched(way, setup)], current)


def distinct(rivals: list[Pose2], pose2: Pose2) -> list[Pose2]:
    """The rivals, each once, and none that is the true place."""
    kept: list[Pose2] = []
    for rival in rivals:
        if not any(_alike(rival, other) for other in (pose2, *kept)):
            kept.append(rival)
    return kept


def _alike(pose2: Pose2, other: Pose2) -> bool:
    return pose2.distance_to(other) < APART_XY and abs(pose2.turn_to(other)) < APART_THETA


def _turned(pose: Pose2, field: Field) -> list[Pose2]:
    """By quarters about the middle of the tape."""
    points = field.edges.reshape(-1, 2)
    middle = Pose2(*((points.min(axis=0) + points.max(axis=0)) / 2).tolist())
    seen = middle.inverse() @ pose
    return [middle @ Pose2(theta=quarter * math.pi / 2) @ seen for quarter in (1, 2, 3)]


def _searched(way: Way, setup: Setup) -> list[Pose2]:
    """What a search over the whole field finds for the way so far, at some moments of it."""
    local = LocalMap.of(setup.hypotheses)
    left = [way.stamps[0] + seconds for seconds in SEARCHES]
    pose2s: list[Pose2] = []
    for place, scan in enumerate(way.scans):
        local.move(way.step(place))
        local.add(scan)
        if left and scan.stamp >= left[0]:
            left.pop(0)
            search = PlaceSearch(local, [], setup)
            while not search.advance():
                pass
            truth = way.truths[place]
            pose2s += [way.at_first(life.pose @ search.since, truth) for life in search.found]
    return pose2s


def _claimed(way: Way, claims: Claims) -> list[Pose2]:
    """Where the filter ever held the robot to be on the way, though wrongly, longest first."""
    some = np.flatnonzero((claims.stamps >= way.stamps[0]) & ~right(claims))
    some = some[np.isfinite(claims.poses[some]).all(axis=1)]
    groups: list[tuple[Pose2, int]] = []
    for place in some:
        truth = Pose2(*claims.truth[place].tolist())
        pose = way.at_first(Pose2(*claims.poses[place].tolist()), truth)
        for which, (other, count) in enumerate(groups):
            if _alike(pose, other):
                groups[which] = other, count + 1
                break
        else:
            groups.append((pose, 1))
    groups.sort(key=lambda item: -item[1])
    return [pose for pose, _ in groups[:MOST_CLAIMED]]
