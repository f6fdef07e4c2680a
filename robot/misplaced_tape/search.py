"""MisplacedTapeSearch: finds which piece of tape lies elsewhere, or not at all.

While a robot's place is in doubt, its way is followed from where it was known: by all tape, and for
each piece that may be elsewhere by all the other tape. Without the right piece all that is seen
fits, the piece is not seen where it is drawn, and the other tape alone proves the place; else the
robot itself may have been moved.

The numbers were chosen on drives with seeds 20100 to 20103 and 21000 to 21502 over *square*,
*town*, *tee*, *stub* and generated fields, with tape as drawn, elsewhere, missing and laid by hand,
and with robots that slip, are stuck, pushed or carried off, or see late.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from robot.covariance import inverse, widest
from robot.geometry import Array, Pose2
from robot.misplaced_tape.tape_drawing import PlaceFollower, TapeDrawing
from robot.scan import Scan, rays_of

STANDS_M, STANDS_RAD = 0.001, 0.003
"""A robot that has moved by less sees the same again [m], [rad]."""
RAYS = 61
"""So many rays of a scan are enough."""
SHORTEST = 0.1
"""A shorter piece is not suspected: too few rays meet it [m]."""
SUSPECTED = 12
"""A piece is suspected after so many rays have missed it, or see tape beside it."""
MOST_SUSPECTED = 6
"""No more pieces are suspected at a time."""
PULLED_M = 0.01
"""So far tape that lies elsewhere may have pulled the place before it is suspected [m]."""
ENOUGH, ENOUGH_SHARE = 80, 0.03
"""So many rays must not fit all tape, and so large a share of those that do."""
LEFT, LEFT_SHARE = 0.2, 0.03
"""At most this share of them may not fit without the piece, and this share of those that do."""
FITTING, FITTING_SO_FAR = 150, 60
"""So many returns must fit other tape; and so many, before it is doubted what else is claimed."""
THROUGH = 30
"""So many rays must look where the piece is drawn, and not see it."""
IN_PLACE = 0.15
"""The piece may be seen in its place by so large a share of the rays that look there."""
SURE_M = 0.015
"""So well [m], one standard deviation, the other tape alone must tell the place."""
FOLLOWED_M = 0.06
"""By odometry and the other tape the robot is only found where it was expected, if that was known
so well [m], one standard deviation."""
LEAP = 6.5
"""A scan may have moved the place by no more standard deviations of odometry: it was known."""
RIVAL = 3.0
"""Without another piece so many times more must be left."""
TOGETHER, SPREAD = 0.6, 0.025
"""Of the returns beside its place so large a share lies within this of their median [m]: the
piece."""
FEW, FEW_SHARE = 40, 0.1
"""Fewer returns there are not the piece, and a smaller share of the rays that miss it."""
EXACT_M = 0.01
"""How far it lies aside is told if it was seen so exactly, one standard deviation [m]."""
SMALL = 0.05
"""Tape that lies less aside is not misplaced, only laid by hand [m]."""


@dataclass(frozen=True)
class Misplaced:
    """A piece of tape that does not lie where the drawing has it."""

    piece: int
    """Its number."""
    aside: float | None
    """How far it lies aside [m]; None if it was not seen, or not exactly."""


class MisplacedTapeSearch:
    """Looks for the piece from a known place on; scan by scan, for one thread."""

    def __init__(
        self, drawing: TapeDrawing, pose: Pose2, covariance: Array, odometry: Pose2
    ) -> None:
        """Begin where the robot was known to be, with a covariance (3, 3) [m, m, rad]."""
        self._drawing = drawing
        self._odometry = odometry
        self._whole = drawing.follower(pose, covariance)
        self._others: list[PlaceFollower] = []
        self._suspicion = np.zeros(len(drawing.pieces), dtype=np.intp)

    def add(self, scan: Scan, odometry: Pose2) -> Misplaced | None:
        """Take one more scan, and odometry at its stamp; return what is found by now."""
        moved = self._odometry.inverse() @ odometry
        if stands(moved):
            return None
        self._odometry = odometry
        rays = rays_of(scan, RAYS)
        for follower in (self._whole, *self._others):
            follower.tracker.step(moved, rays)
            look = self._drawing.look(follower, rays)
            if follower is self._whole:
                np.add.at(self._suspicion, np.concatenate(look), 1)
        self._suspect()
        return self._finding()

    @property
    def rival(self) -> Pose2 | None:
        """Where the robot is if a piece lies elsewhere, as nothing contradicts; else None."""
        whole = self._whole
        if whole.misses < ENOUGH:
            return None
        explaining = [each for each in self._others if _may_explain(each, whole)]
        return min(explaining, key=_rest).tracker.pose if explaining else None

    def settle(self, pose: Pose2, covariance: Array) -> Misplaced | None:
        """Return what explains the doubt, now that the place is known again; None if nothing does.

        Args:
            pose: where the robot is.
            covariance: (3, 3) [m, m, rad].
        """
        whole = self._whole
        if whole.misses < ENOUGH:
            return None
        explaining = [each for each in self._others if _led_to(each, whole, pose, covariance)]
        return self._best(explaining)

    def without(self, piece: int) -> PlaceFollower:
        """Return who follows the robot without a piece."""
        return next(each for each in self._others if each.piece == piece)

    def _suspect(self) -> None:
        """Follow the robot also without pieces that are often missed."""
        known = {each.piece for each in self._others}
        whole = self._whole.tracker
        for number in np.argsort(-self._suspicion, kind="stable").tolist():
            if self._suspicion[number] < SUSPECTED or len(known) >= MOST_SUSPECTED:
                return
            if number in known or self._drawing.pieces[number].length < SHORTEST:
                continue
            if self._whole.misses - self._suspicion[number] > ENOUGH:
                # By now other tape has led astray who would be followed.
                continue
            if len(self._drawing.pieces) > 1:
                known.add(number)
                wider = whole.covariance + np.diag([PULLED_M**2, PULLED_M**2, 0.0])
                self._others.append(self._drawing.follower(whole.pose, wider, number))

    def _finding(self) -> Misplaced | None:
        whole = self._whole
        if whole.misses < max(ENOUGH, ENOUGH_SHARE * whole.fits):
            return None
        return self._best([each for each in self._others if _explains(each, whole)])

    def _best(self, explaining: list[PlaceFollower]) -> Misplaced | None:
        if not explaining:
            return None
        best, *rivals = sorted(explaining, key=_rest)
        if rivals and _rest(rivals[0]) < RIVAL * _rest(best):
            return None
        return misplaced(best)


def stands(moved: Pose2) -> bool:
    """Whether a robot that has moved so sees the same again."""
    return math.hypot(moved.x, moved.y) < STANDS_M and abs(moved.theta) < STANDS_RAD


def misplaced(follower: PlaceFollower) -> Misplaced | None:
    """Return what the piece that a follower leaves out is; None if it is laid by hand only."""
    assert follower.piece is not None
    if follower.beside < max(FEW, FEW_SHARE * follower.through):
        return Misplaced(follower.piece, None)
    offsets, is_exact = np.array(follower.offsets), follower.exactness < EXACT_M
    middle = float(np.median(offsets))
    together = (np.abs(offsets - middle) < SPREAD).mean() > TOGETHER
    if abs(middle) < SMALL or (is_exact and not together):
        return None
    return Misplaced(follower.piece, abs(middle) if is_exact else None)


def _rest(follower: PlaceFollower) -> float:
    """Return how much does not fit, as a share of what does."""
    return (follower.misses + 1) / (follower.fits + 1)


def _explains(follower: PlaceFollower, whole: PlaceFollower) -> bool:
    """Whether a piece that lies elsewhere explains what was seen, and the other tape the place."""
    return (
        _may_explain(follower, whole)
        and follower.fits >= FITTING
        and follower.through >= THROUGH
        and widest(follower.tracker.by_scans) < SURE_M
    )


def _may_explain(follower: PlaceFollower, whole: PlaceFollower) -> bool:
    """Whether nothing contradicts that a piece lies elsewhere, and what was seen does else."""
    looked = follower.in_place + follower.through
    return (
        follower.fits >= FITTING_SO_FAR
        and follower.beside + follower.through >= THROUGH
        and follower.misses <= min(LEFT * whole.misses, LEFT_SHARE * follower.fits)
        and follower.in_place <= IN_PLACE * looked
        and follower.tracker.leap < LEAP
    )


def _led_to(follower: PlaceFollower, whole: PlaceFollower, pose: Pose2, covariance: Array) -> bool:
    """Whether odometry has led to where the robot is, and it looked through the piece meanwhile."""
    tracker = follower.tracker
    looked = follower.in_place + follower.through
    apart = tracker.pose.offset_to(pose)
    squared = float(apart @ inverse(tracker.covariance + covariance) @ apart)
    return (
        follower.through >= ENOUGH
        and follower.misses
        <= min(LEFT * whole.misses, LEFT_SHARE * (follower.fits + follower.through))
        and follower.in_place <= IN_PLACE * looked
        and tracker.width < FOLLOWED_M
        and squared < LEAP**2
    )
