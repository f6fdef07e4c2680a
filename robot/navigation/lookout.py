"""``look``: the move by which a robot that does not know its place learns most, clear of tape."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import cv2
import numpy as np
from numpy.typing import NDArray

from robot.geometry import Array, Pose2, wrap_angle
from robot.navigation.free_space import FreeSpace
from robot.navigation.legs import WayLeg, straight, turn
from robot.navigation.place_kernels import ranges_from, reaches, steps_clear
from robot.navigation.possible_places import Glimpse, places_seen
from robot.navigation.seen_tape import tape_seen
from robot.scan import Scan

MARGIN_M = 0.003
"""Room that the outline keeps to tape at each place where the robot may be [m]."""
SEEN_MARGIN_M = 0.008
"""Room that it keeps to tape that it has seen itself [m]. Points on the outline are 12 mm apart:
with 4 mm, tape may lie between two of them."""
RISKS = (0.001, 0.01, 0.03, 0.08, 0.2)
"""Share of the places at which a move may come nearer to tape. The first is that of one place, as
none is clear of chance; the next ones are dared where no move was found before, one after the
other: else a robot that sees no tape, beside tape, would stand for ever."""
RISK_COSTS = (20.0, 8.0, 4.0, 2.0, 1.0)
"""What risk costs in gain, with each of them."""
TOLD_M = 0.08
"""Ranges that differ by so much, on all rays, tell two places apart [m]. With 0.03, what places of
one heap differ by counted as gain, and the robot turned to and fro by small angles in a corner."""
SAME_M, SAME_RAD = 0.08, 0.25
"""Places that are nearer to each other need not be told apart."""
ONLY = 0.95
"""Share of the places that are at one: then it is the only one."""
SURE_M, SURE_RAD = (0.01, 0.01), 0.03
"""Standard deviations that are added to those of the places [m, rad]: they agree with what was seen
to a few millimetres, and the robot may have been seen from a little elsewhere."""
LEAST_GAIN = 0.02
"""A move is worth it that tells apart more than this share of pairs of places."""
SIGHT_GAIN = 0.2
"""Gain of a move after which all rays see tape. Without it, a robot whose views leave a single
place stands as soon as no move would tell places apart, though its filter still doubts the place:
one that was pushed on ``tee`` stood for good."""
NEWS_RAD, NEWS_M = 0.5, 0.3
"""A view counts in full that is turned or moved by so much from each one before [rad, m]."""
OPEN_GAIN = 0.3
"""Gain of a move after which the robot can turn all around, where it could not before. Without it,
a robot in a corner of ``tee`` turned to and fro by small angles."""
EFFORT = 0.01
"""Gain that a second of driving has to bring."""
COMPARED = 200
"""So many places are compared in pairs."""
TURNS = (0.1, 0.2, 0.35, 0.5, 0.75, 1.0, 1.3, 1.6, 2.0, 2.4)
"""Turns that are compared, to either side [rad]."""
AHEAD, BACK = (0.02, 0.04, 0.07, 0.1, 0.15, 0.2, 0.3, 0.4), (0.02, 0.04, 0.07, 0.1, 0.15)
"""Straight ways that are compared [m]."""
FIRST = (0.05, 0.1, 0.2, 0.3, -0.05, -0.1)
"""Straight ways after which turns are compared [m]."""
FIRST_TURNS = (0.5, 1.0, 1.6, 2.4, -0.5, -1.0, -1.6, -2.4)
"""Turns after which straight ways ahead are compared [rad]."""
TURN_STEP, STEP = 0.05, 0.01
"""The outline is compared with walls so often on a move [rad, m]."""
SEES_RAD, SEES_RAYS = 0.5, 13
"""How far to each side it is expected to see [rad], and by how many rays."""
SEES_M = (0.16, 0.7)
"""What a robot is expected to see ahead of it: the middle of its camera's view [m]."""
FLOOR_M, FLOOR_CELL_M = 0.9, 0.01
"""Floor that was seen is remembered so far around the robot, in cells of this side [m]."""
SEEN_SHORT_M = 0.02
"""A ray has seen floor up to so far before its end [m]."""


@dataclass(frozen=True, eq=False)
class OnlyPlace:
    """The only place where the robot may be, by what it has seen."""

    pose: Pose2
    covariance: Array = field(repr=False)
    """(3, 3) [m, m, rad]"""


@dataclass(frozen=True, eq=False)
class Move:
    """What a robot does to learn where it is."""

    legs: tuple[WayLeg, ...]
    """In the odometry's frame; none if it shall stand."""
    reason: str
    """In words for people."""
    rim: Array = field(default_factory=lambda: np.zeros((0, 2)), compare=False, repr=False)
    """(k, 2) the robot's outline [m], which shall not come to tape that it sees on the way; empty
    where it may cross tape."""
    place: OnlyPlace | None = None
    """Where it is, if there is no move and only one place is left."""


@dataclass(frozen=True, eq=False)
class Sweep:
    """A motion of one kind, as far as it may be driven: its steps, and what each place allows."""

    before: Pose2
    """What is driven before it: straight ahead by ``x``, or turned by ``theta``."""
    turns: bool
    """Whether it is a turn on the spot, and else straight."""
    step: float
    """Of each step, with its sign [rad or m]."""
    reach: NDArray[np.int64]
    """(n,) steps at each place until the outline comes to a wall; -1 where it does before it."""

    @property
    def amounts(self) -> tuple[float, ...]:
        """Those that are compared, from the least on [rad or m]."""
        if self.turns:
            return TURNS[3::2] if self.before.x else TURNS
        if self.before.theta:
            return AHEAD[3::2]
        return AHEAD if self.step > 0 else BACK

    @property
    def backs(self) -> bool:
        """Whether the robot goes backwards, where its camera does not look."""
        return self.before.x < 0 or (not self.turns and self.step < 0)

    def risk(self, amount: float) -> float:
        """Return the share of places at which the outline comes to a wall on the way."""
        return float((self.reach < math.ceil(amount / abs(self.step) - 1e-6)).mean())

    def allows(self, risk: float, level: int) -> bool:
        """Whether a risk may be run at a level of daring: backwards, no more than at the first."""
        return risk <= RISKS[0 if self.backs else level]

    def moved(self, amount: float) -> Pose2:
        """Return the motion in the robot's frame."""
        signed = math.copysign(amount, self.step)
        return self.before @ (Pose2(0.0, 0.0, signed) if self.turns else Pose2(signed))

    def effort(self, amount: float) -> float:
        """Return about how long it takes [s]."""
        turned = abs(self.before.theta) + (amount if self.turns else 0.0)
        return turned / 1.5 + (abs(self.before.x) + (0.0 if self.turns else amount)) / 0.15

    def legs(self, pose: Pose2, amount: float) -> tuple[WayLeg, ...]:
        """Return the same from a pose on."""
        signed, first = math.copysign(amount, self.step), self.before
        legs: tuple[WayLeg, ...] = ()
        if first.x:
            legs = (straight(pose, first.x),)
        elif first.theta:
            legs = (turn(pose, pose.theta + first.theta),)
        begin = legs[-1].end if legs else pose
        last = turn(begin, begin.theta + signed) if self.turns else straight(begin, signed)
        return (*legs, last)


def look(
    views: Sequence[Glimpse],
    odom: Pose2,
    marks: FreeSpace,
    free: FreeSpace,
    believed: Sequence[Pose2] = (),
    *,
    dares: int = 0,
    crosses_tape: bool = False,
) -> Move:
    """Return the move that tells most of the places apart at which the robot may be.

    The places are drawn at random, and weighed by what was seen. A move is compared by the share of
    pairs of places that would see something else after it, which is what is expected to be gained.
    At none of the places may the outline come to tape on the way, unless it stays on floor that was
    seen to be free, or where the robot has stood: that holds wherever the robot is. So does tape
    that was seen: no move comes to it, however much is dared. Backwards, where it does not see what
    it comes to, nothing is dared: it goes back where all places are free, or turns first.

    Args:
        views: what was seen since the place is in doubt; one or more.
        odom: the robot's odometry now.
        marks: distances to all that the robot can see.
        free: distances to what it must not touch, and its outline.
        believed: poses in the map that a filter holds for possible now.
        dares: how often no move was found before: then it runs a risk.
        crosses_tape: whether it may cross tape.
    """
    places = places_seen(views, odom, marks, free, believed)
    floor = ClearFloor.of(views, odom, free.hollow.body)
    tape = np.zeros((0, 2)) if crosses_tape else tape_seen(views, odom)
    sweeps = sweeps_of(places, floor, free, tape)
    some = _compared(places, believed)
    openness = _openness(some, free)
    best: tuple[Sweep, float] | None = None
    most, clear, share = LEAST_GAIN, False, ""
    for level in range(min(dares, len(RISKS) - 1) + 1):
        for sweep in sweeps:
            for amount in sweep.amounts:
                risk = sweep.risk(amount)
                if not sweep.allows(risk, level):
                    break
                clear = True
                moved = sweep.moved(amount)
                if any(view.is_at(odom @ moved) for view in views):
                    continue
                ends = _moved(some, moved)
                ranges = seen_from(ends, marks)
                apart = told_apart(some, ranges)
                sight = float((ranges < SEES_M[1]).mean()) * _news(views, odom @ moved)
                gain = apart + SIGHT_GAIN * sight
                gain += OPEN_GAIN * (_openness(ends, free) - openness)
                gain -= RISK_COSTS[level] * risk + EFFORT * sweep.effort(amount)
                if gain > most:
                    best, most, share = (sweep, amount), gain, f"{100 * apart:.0f}"
        if best is not None:
            sweep, amount = best
            legs = sweep.legs(odom, amount)
            rim = free.hollow.body[: 0 if crosses_tape else None]
            return Move(legs, f"a move tells {share} % of the places apart", rim)
    if clear:
        return Move((), reason="no move would tell it more", place=only_place(places))
    return Move((), reason="no move is clear of walls at each place where it may be")


def only_place(places: Array) -> OnlyPlace | None:
    """Return where nearly all places (n, 3) are; None if they are not all at one."""
    some = places[:COMPARED]
    alike = np.hypot(*(some[:, None, :2] - some[None, :, :2]).transpose(2, 0, 1)) < SAME_M
    alike &= np.abs(wrap_angle(some[:, None, 2] - some[None, :, 2])) < SAME_RAD
    middle = some[alike.sum(axis=1).argmax()]
    away = places - middle
    away[:, 2] = wrap_angle(away[:, 2])
    near = away[(np.hypot(away[:, 0], away[:, 1]) < SAME_M) & (np.abs(away[:, 2]) < SAME_RAD)]
    if len(near) < ONLY * len(places):
        return None
    covariance = np.cov(near.T) + np.diag(np.square([*SURE_M, SURE_RAD]))
    return OnlyPlace(Pose2.from_array(middle + near.mean(axis=0)), covariance)


def _compared(places: Array, believed: Sequence[Pose2]) -> Array:
    """Return places (n, 3) by which moves are compared, in a random order.

    Those that a filter cannot tell apart are among them: it has to know the place in the end.
    """
    some = places[:COMPARED].copy()
    if len(believed) > 1:
        filters = np.array([pose.to_array() for pose in believed])
        some[: COMPARED // 3] = np.resize(filters, (min(COMPARED // 3, len(some)), 3))
    return np.random.default_rng(0).permutation(some)


def _news(views: Sequence[Glimpse], odom: Pose2) -> float:
    """Return the share of a view at an odometry that no view before has shown."""
    share = 1.0
    for view in views:
        turned = abs(odom.turn_to(view.odom_from_robot)) / NEWS_RAD
        share = min(share, turned + odom.distance_to(view.odom_from_robot) / NEWS_M)
    return share


def _openness(places: Array, free: FreeSpace) -> float:
    """Return the share of places (n, 3) where the robot can turn all around."""
    return float((free.clearance(places[:, :2]) > free.radius + MARGIN_M).mean())


def sweeps_of(
    places: Array, floor: ClearFloor, free: FreeSpace, tape: Array = np.zeros((0, 2))
) -> list[Sweep]:
    """Return the motions that are compared, and how far each place (n, 3) allows them.

    Tape that was seen, (m, 2) [m] in the robot's frame, is in the way at each place.
    """
    rim = free.hollow.body

    def reach(steps: Array) -> NDArray[np.int64]:
        known = floor.has(steps, rim)
        seen = steps_clear(steps, rim, tape, SEEN_MARGIN_M)
        reached = reaches(places, steps, rim, known, free.distance, free.frame, MARGIN_M)
        return np.minimum(reached, seen)

    def after(before: Pose2, blocked: NDArray[np.bool_], steps: Array) -> NDArray[np.int64]:
        # What room it keeps is that of its place now: the first step.
        cos, sin = math.cos(before.theta), math.sin(before.theta)
        x, y, theta = steps.T
        poses = (before.x + cos * x - sin * y, before.y + sin * x + cos * y, before.theta + theta)
        reached = reach(np.concatenate([np.zeros((1, 3)), np.column_stack(poses)])) - 1
        reached[blocked] = -1
        return reached

    ahead, back = _line(STEP, AHEAD[-1]), _line(-STEP, BACK[-1])
    left, right = _turning(TURN_STEP), _turning(-TURN_STEP)
    at_once = Pose2()
    sweeps = [
        Sweep(at_once, False, STEP, reach(ahead)),
        Sweep(at_once, False, -STEP, reach(back)),
        Sweep(at_once, True, TURN_STEP, reach(left)),
        Sweep(at_once, True, -TURN_STEP, reach(right)),
    ]
    for first in FIRST:
        blocked = sweeps[0 if first > 0 else 1].reach < round(abs(first) / STEP)
        before = Pose2(first)
        sweeps.append(Sweep(before, True, TURN_STEP, after(before, blocked, left)))
        sweeps.append(Sweep(before, True, -TURN_STEP, after(before, blocked, right)))
    for angle in FIRST_TURNS:
        blocked = sweeps[2 if angle > 0 else 3].reach < round(abs(angle) / TURN_STEP)
        before = Pose2(0.0, 0.0, angle)
        sweeps.append(Sweep(before, False, STEP, after(before, blocked, ahead)))
    return sweeps


def _line(step: float, length: float) -> Array:
    steps = np.zeros((round(length / abs(step)) + 1, 3))
    steps[:, 0] = step * np.arange(len(steps))
    return steps


def _turning(step: float) -> Array:
    steps = np.zeros((round(TURNS[-1] / abs(step)) + 1, 3))
    steps[:, 2] = step * np.arange(len(steps))
    return steps


def _moved(places: Array, moved: Pose2) -> Array:
    """Return where robots at places (n, 3) are after a motion in their frame, (n, 3)."""
    cos, sin = np.cos(places[:, 2]), np.sin(places[:, 2])
    x = places[:, 0] + cos * moved.x - sin * moved.y
    y = places[:, 1] + sin * moved.x + cos * moved.y
    return np.column_stack([x, y, places[:, 2] + moved.theta])


@dataclass(frozen=True, eq=False)
class ClearFloor:
    """Floor around the robot that it has seen to be free of tape, or stood on: wherever it is."""

    free: NDArray[np.bool_]
    """(n, n) cells around the robot, x by row, in its frame now."""

    @classmethod
    def of(cls, views: Sequence[Glimpse], odom: Pose2, rim: Array = np.zeros((0, 2))) -> ClearFloor:
        """Return the floor that views have seen, for a robot with an odometry.

        And what an outline, by points on its rim (k, 2) [m], has covered where it stood for them.
        """
        count = round(2 * FLOOR_M / FLOOR_CELL_M)
        middles = (np.arange(count) + 0.5) * FLOOR_CELL_M - FLOOR_M
        x, y = np.meshgrid(middles, middles, indexing="ij")
        points = np.column_stack([x.ravel(), y.ravel()])
        free = np.zeros(len(points), np.bool_)
        for view in views:
            free |= _is_seen(view.scan, (odom.inverse() @ view.odom_from_robot).inverse(), points)
        cells = free.reshape(count, count)
        stood = np.zeros((count, count), np.uint8)
        if len(rim):
            for pose in (odom, *(view.odom_from_robot for view in views)):
                corners = (odom.inverse() @ pose).apply(rim)
                hull = cv2.convexHull(((corners + FLOOR_M) / FLOOR_CELL_M - 0.5).astype(np.float32))
                # Columns of the picture are y. What is far away is not remembered.
                shown = np.rint(np.clip(hull[:, 0, ::-1], -count, 2 * count)).astype(np.int32)
                cv2.fillConvexPoly(stood, shown, 1)
        return cls(cells | (stood > 0))

    def has(self, steps: Array, rim: Array) -> NDArray[np.bool_]:
        """Return which points of an outline (k, 2) lie on it at poses (s, 3): (s, k)."""
        cos, sin = np.cos(steps[:, 2])[:, None], np.sin(steps[:, 2])[:, None]
        x = steps[:, :1] + cos * rim[:, 0] - sin * rim[:, 1]
        y = steps[:, 1:2] + sin * rim[:, 0] + cos * rim[:, 1]
        rows = np.floor((x + FLOOR_M) / FLOOR_CELL_M).astype(np.intp)
        columns = np.floor((y + FLOOR_M) / FLOOR_CELL_M).astype(np.intp)
        last = len(self.free) - 1
        inside = (rows >= 0) & (columns >= 0) & (rows <= last) & (columns <= last)
        known: NDArray[np.bool_] = inside & self.free[rows.clip(0, last), columns.clip(0, last)]
        return known


def _is_seen(scan: Scan, scan_from_here: Pose2, points: Array) -> NDArray[np.bool_]:
    """Return which points (n, 2) a scan has seen free: rays on both sides go beyond them."""
    local = (scan.robot_from_scan.inverse() @ scan_from_here).apply(points)
    bearing, away = np.arctan2(local[:, 1], local[:, 0]), np.hypot(local[:, 0], local[:, 1])
    after = np.searchsorted(scan.bearings, bearing)
    inside = (after > 0) & (after < len(scan.bearings))
    after = after.clip(1, max(1, len(scan.bearings) - 1))
    if len(scan.bearings) < 2 or scan.sight is None:
        return np.zeros(len(points), np.bool_)
    seen = inside
    for ray in (after - 1, after):
        near, far = scan.sight[ray, 0], scan.sight[ray, 1]
        # A ray without sight is nan, and so False.
        seen = seen & (away >= near) & (away <= np.minimum(far, scan.ranges[ray] - SEEN_SHORT_M))
        if scan.hidden is not None:
            seen = seen & ~((away >= scan.hidden[ray, 0]) & (away <= scan.hidden[ray, 1]))
    return seen


def seen_from(places: Array, marks: FreeSpace) -> Array:
    """Return the ranges (n, k) [m] that a robot sees from places (n, 3); what is far is alike."""
    bearings = np.linspace(-SEES_RAD, SEES_RAD, SEES_RAYS)
    return ranges_from(places, bearings, np.array(SEES_M), marks.distance, marks.frame)


def told_apart(places: Array, ranges: Array) -> float:
    """Return the share of pairs of places (n, 3) which their ranges (n, k) [m] tell apart."""
    half = len(ranges) // 2
    between = places[:half] - places[half : 2 * half]
    turned = np.abs((between[:, 2] + math.pi) % (2 * math.pi) - math.pi)
    differ = (np.hypot(between[:, 0], between[:, 1]) > SAME_M) | (turned > SAME_RAD)
    apart = np.minimum(np.abs(ranges[:half] - ranges[half : 2 * half]) / TOLD_M, 3.0).mean(axis=1)
    return float((differ * (1 - np.exp(-(apart**2)))).mean())
