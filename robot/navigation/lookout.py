"""``look``: the move by which a robot that does not know its place learns most, clear of tape."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from robot.geometry import Array, Pose2, heading_vectors
from robot.navigation.free_space import FreeSpace
from robot.navigation.legs import WayLeg, straight, turn
from robot.scan import Scan

DRAWN, KEPT, WEIGHED = 24_000, 3000, 600
"""Places that are drawn all over the field, that are followed, and by which moves are compared."""
SDS = (0.08, 0.05, 0.03, 0.02)
"""What is seen is compared with the field ever more strictly [m]."""
OUTLIER = 4.0
"""A point counts against a place by at most this, as a logarithm."""
ON_TAPE = 1.5
"""A point that was seen free counts so much against a place where it lies on tape."""
FIRST_VIEWS = 3
"""The newest views by which places are chosen that were drawn all over the field."""
WITHIN_M = 0.05
"""The robot's middle is at least so far from tape that it does not stand on [m]."""
STANDS_ON_TAPE = 60.0
"""Counts against a place where the robot would stand on tape: it was not put there."""
CHUNK = 250_000
"""So many points are looked up at once: the thread that drives waits no longer for one look-up."""
INDEPENDENT = 12.0
"""So many points of a view count as one: their errors are alike."""
SAME_VIEW_M, SAME_VIEW_RAD = 0.01, 0.05
"""Views that are nearer to each other say the same."""
RAYS, STEP_M, SHORT_M = 23, 0.03, 0.03
"""Rays of a view that count, points along them, and how far before its end a ray is free."""
MARGIN_M = 0.002
"""Room that the outline keeps to tape at each place where the robot may be [m]."""
MOST_RISK = 0.004
"""Share of the places at which a move may come nearer to tape: one or two of ``WEIGHED``."""
DARED, RISK_COSTS = 0.04, 8.0
"""Where there is none, the robot dares a move with at most this risk; and what risk costs in gain.
Else a robot that sees no tape, beside tape, would stand for ever."""
INSIDE = 0.8
"""Share of the places that are drawn where robots usually drive; the others, all over the floor."""
TOLD_M = 0.03
"""Ranges that differ by so much tell two places apart [m]."""
LEAST_GAIN = 0.02
"""A move is worth it that tells apart more than this share of pairs of places."""
TURNS = (0.25, 0.5, 1.0, 1.6, 2.4, -0.25, -0.5, -1.0, -1.6, -2.4)
"""Turns that are compared [rad]."""
DISTANCES = (0.03, 0.06, 0.1, 0.2, 0.3, -0.03, -0.06, -0.1)
"""Straight ways that are compared [m]."""
EFFORT = 0.02
"""Gain that a second of driving has to bring."""
SEES_RAD, SEES_RAYS = 0.5, 13
SEES_M = (0.16, 0.7)
"""What a robot is expected to see ahead of it: the middle of its camera's view [m]."""


@dataclass(frozen=True, eq=False)
class Glimpse:
    """A scan, and where the robot was by its odometry."""

    odom_from_robot: Pose2
    scan: Scan

    def is_elsewhere(self, other: Glimpse) -> bool:
        """Whether the robot stood elsewhere for another view: else both say the same."""
        apart = self.odom_from_robot.distance_to(other.odom_from_robot)
        turned = abs(self.odom_from_robot.turn_to(other.odom_from_robot))
        return apart > SAME_VIEW_M or turned > SAME_VIEW_RAD


@dataclass(frozen=True)
class Move:
    """What a robot does to learn where it is."""

    legs: tuple[WayLeg, ...]
    """In the odometry's frame; none if it shall stand."""
    reason: str
    """In words for people."""


def look(
    views: Sequence[Glimpse],
    odom: Pose2,
    marks: FreeSpace,
    free: FreeSpace,
    believed: Sequence[Pose2] = (),
    *,
    dares: bool = False,
) -> Move:
    """Return the move that tells most of the places apart at which the robot may be.

    The places are drawn at random, and weighed by what was seen. A move is compared by the share of
    pairs of places that would see something else after it, which is what is expected to be gained.
    At none of the places may the outline come to tape on the way.

    Args:
        views: what was seen since the place is in doubt; one or more.
        odom: the robot's odometry now.
        marks: distances to all that the robot can see.
        free: distances to what it must not touch, and its outline.
        believed: poses in the map that a filter holds for possible now.
        dares: whether a small risk is run, since without it no move was found before.
    """
    most_risk = DARED if dares else MOST_RISK
    places, rim = places_seen(views, odom, marks, free, believed), free.hollow
    best, most = None, 0.0
    safe = 0
    for legs in _moves(odom):
        touches = risk(places, odom, legs, rim)
        if touches > most_risk:
            continue
        safe += 1
        end = odom.inverse() @ legs[-1].end
        ends = _moved(places, end)
        gain = told_apart(seen_from(ends, marks)) - EFFORT * _effort(legs) - RISK_COSTS * touches
        if gain > most:
            best, most = legs, gain
    if best is None or most < LEAST_GAIN:
        if safe:
            return Move((), reason="no move would tell it more")
        return Move((), reason="no move is clear of walls at each place where it may be")
    share = f"{100 * most:.0f}"
    return Move(best, reason=f"a move tells {share} % of the places apart")


def _moves(odom: Pose2) -> list[tuple[WayLeg, ...]]:
    turns = [(turn(odom, odom.theta + angle),) for angle in TURNS]
    return [*turns, *((straight(odom, distance),) for distance in DISTANCES)]


def _effort(legs: tuple[WayLeg, ...]) -> float:
    """Return about how long legs take [s]."""
    turned = sum(abs(float(leg.poses[-1, 2] - leg.poses[0, 2])) for leg in legs)
    return turned / 1.5 + sum(leg.length for leg in legs) / 0.15


def risk(places: Array, odom: Pose2, legs: tuple[WayLeg, ...], free: FreeSpace) -> float:
    """Return the share of places (n, 3) at which the outline comes to a wall on the way.

    Args:
        places: where the robot may be.
        odom: its odometry now.
        legs: the way, in the odometry's frame.
        free: distances to walls, and the outline.
    """
    touched = np.zeros(len(places), np.bool_)
    first = _room(places, odom, odom, free)
    for leg in legs:
        turned = abs(float(leg.poses[-1, 2] - leg.poses[0, 2]))
        count = max(2, math.ceil(turned / 0.12), math.ceil(leg.length / 0.02))
        steps = np.linspace(0, len(leg.poses) - 1, count + 1)[1:]
        for step in steps:
            low = math.floor(step)
            share = step - low
            pose = leg.poses[low]
            if share:
                pose = pose + share * (leg.poses[low + 1] - pose)
            room = _room(places, odom, Pose2.from_array(pose), free)
            # Where it stands already it may be nearer; it must not come nearer still.
            touched |= room < np.minimum(MARGIN_M, first)
    return float(touched.mean())


def _room(places: Array, odom: Pose2, pose: Pose2, free: FreeSpace) -> Array:
    return free.room(_moved(places, odom.inverse() @ pose))


def _moved(places: Array, moved: Pose2) -> Array:
    """Return where robots at places (n, 3) are after a motion in their frame, (n, 3)."""
    cos, sin = np.cos(places[:, 2]), np.sin(places[:, 2])
    x = places[:, 0] + cos * moved.x - sin * moved.y
    y = places[:, 1] + sin * moved.x + cos * moved.y
    return np.column_stack([x, y, places[:, 2] + moved.theta])


def places_seen(
    views: Sequence[Glimpse],
    odom: Pose2,
    marks: FreeSpace,
    free: FreeSpace,
    believed: Sequence[Pose2] = (),
) -> Array:
    """Return places (n, 3) in the map where the robot may be now, all as likely.

    They are drawn all over the field, and chosen by what was seen, ever more strictly.
    """
    # The same for the same views: drives repeat exactly.
    rng = np.random.default_rng(len(views))
    places = rng.uniform(size=(DRAWN, 3))
    inside = round(INSIDE * DRAWN)
    places[:inside] = _within(places[:inside], free.drive_area)
    places[inside:] = _within(places[inside:], free.extent)
    seen = [(odom.inverse() @ view.odom_from_robot, *_seen(view.scan)) for view in views]
    # The middle of the robot lies inside its outline: it is no wall.
    places = places[free.clearance(places[:, :2]) > WITHIN_M]
    if believed:
        near = np.repeat([pose.to_array() for pose in believed], 20, axis=0)
        places = np.concatenate([places, near + rng.normal(0, (0.01, 0.01, 0.03), near.shape)])
    for number, sd in enumerate(SDS):
        scores = np.zeros(len(places))
        for moved, hits, clear in seen[-FIRST_VIEWS:] if number == 0 else seen:
            some = 3 if number == 0 else 1
            scores += _score(_moved(places, moved), hits[::some], clear[::some], marks, sd) * some
        scores[free.room(places) <= 0] -= STANDS_ON_TAPE if number else 0.0
        weights = np.exp((scores - scores.max()) / INDEPENDENT)
        last = number == len(SDS) - 1
        count = WEIGHED if last else KEPT
        shares = (np.arange(count) + rng.uniform()) / count
        chosen = np.searchsorted(np.cumsum(weights) / weights.sum(), shares)
        places = places[np.minimum(chosen, len(places) - 1)]
        if not last:
            blur = sd / 3
            places = places + rng.normal(0, (blur, blur, 4 * blur), places.shape)
    return places


def _within(shares: Array, box: tuple[float, float, float, float]) -> Array:
    """Return places (n, 3) by their shares (n, 3) of a box and of all headings."""
    low, high = np.array([*box[:2], 0.0]), np.array([*box[2:], 2 * math.pi])
    places: Array = low + shares * (high - low)
    return places


def _seen(scan: Scan) -> tuple[Array, Array]:
    """Return the points of a scan that are tape, and those that are free (n, 2) [m]."""
    rays = np.unique(np.linspace(0, len(scan.ranges) - 1, RAYS).round().astype(np.intp))
    some = scan.only(rays)
    sight = some.sight if some.sight is not None else np.tile([0.0, 0.5], (len(rays), 1))
    clear = []
    for direction, distance, (near, far) in zip(
        heading_vectors(some.bearings), some.ranges, sight, strict=True
    ):
        if math.isnan(near):
            continue
        along = np.arange(near + SHORT_M, min(distance - SHORT_M, far), STEP_M)
        clear.append(along[:, None] * direction)
    empty = np.zeros((0, 2))
    return some.points(), some.robot_from_scan.apply(np.concatenate([empty, *clear]))


def _score(places: Array, hits: Array, clear: Array, marks: FreeSpace, sd: float) -> Array:
    """Return the logarithm of how well places (n, 3) agree with what was seen (n,)."""
    misses = np.minimum((_distances(places, hits, marks) / sd) ** 2 / 2, OUTLIER)
    covered = _distances(places, clear, marks) <= 0
    score: Array = -misses.sum(axis=1) - ON_TAPE * covered.sum(axis=1)
    return score


def _distances(places: Array, points: Array, marks: FreeSpace) -> Array:
    """Return the distances to marks (n, k) of points (k, 2) seen from places (n, 3)."""
    cos, sin = np.cos(places[:, 2])[:, None], np.sin(places[:, 2])[:, None]
    x, y = points[:, 0], points[:, 1]
    distances = np.empty((len(places), len(points)))
    step = max(1, CHUNK // max(1, len(points)))
    for low in range(0, len(places), step):
        part = slice(low, low + step)
        points_seen = np.stack(
            [
                places[part, :1] + cos[part] * x - sin[part] * y,
                places[part, 1:2] + sin[part] * x + cos[part] * y,
            ],
            axis=-1,
        )
        distances[part] = marks.clearance(points_seen.reshape(-1, 2)).reshape(points_seen.shape[:2])
    return distances


def seen_from(places: Array, marks: FreeSpace) -> Array:
    """Return the ranges (n, k) [m] that a robot sees from places (n, 3); what is far is alike."""
    bearings = np.linspace(-SEES_RAD, SEES_RAD, SEES_RAYS)
    along = np.arange(SEES_M[0], SEES_M[1], STEP_M / 2)
    points = (heading_vectors(bearings)[:, None] * along[:, None]).reshape(-1, 2)
    met = _distances(places, points, marks).reshape(len(places), len(bearings), -1) <= STEP_M / 3
    first = met.argmax(axis=2)
    ranges: Array = np.where(met.any(axis=2), along[first], SEES_M[1])
    return ranges


def told_apart(ranges: Array) -> float:
    """Return the share of pairs of places whose ranges (n, k) [m] tell them apart."""
    half = len(ranges) // 2
    apart = np.abs(ranges[:half] - ranges[half : 2 * half]) / TOLD_M
    return float((1 - np.exp(-(np.minimum(apart, 3.0).mean(axis=1) ** 2))).mean())
