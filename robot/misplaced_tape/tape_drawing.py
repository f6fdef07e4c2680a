"""TapeDrawing: the pieces of a drawing; it compares scans with them where a place is followed."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from robot import ray_columns as column
from robot.fields.edge_index import index_edges
from robot.fields.edges import lengths, normals
from robot.geometry import Array, Pose2, heading_vectors
from robot.misplaced_tape.pieces import TapePiece, pieces_of
from robot.misplaced_tape.tracker import REACH, Expected, PlaceTracker, expect

NEAR, FAR = 0.5, 3.0
"""Tape counts nearer than this [m]; farther away a pixel sees too much floor. It is hidden up to
there [m]."""
OFF, OFF_BY_RANGE2 = 0.012, 0.03
"""A return fits within this of where it should be [m], and so much more by its squared range
[1/m]."""
PASSES = 0.05
"""A ray that sees this much farther than the tape is, or nothing, has missed it [m]."""
MARGIN = 0.03
"""Tape so near to the ends of what a ray sees may be missed [m]."""
STEEP, CLEAR = 0.3, 0.5
"""A ray may miss tape that it meets at a smaller sine of the angle, or with a smaller probability
of a return."""
BESIDE, BEYOND = 0.3, 0.05
"""Tape that lies elsewhere is no farther than this aside, and beyond the ends of its place [m]."""
REMEMBERED = 1000
"""So many returns beside a piece are remembered: a robot may do without it for hours."""
AS_EXACT = 1.5
"""They are those seen where the place was known nearly as well as at best, by this factor."""

Rays = NDArray[np.bool_]


@dataclass(eq=False)
class PlaceFollower:
    """A place that is followed by some edges, and counts of rays."""

    tracker: PlaceTracker
    across: Array
    """(n, 2) normals of its edges."""
    edges: NDArray[np.intp]
    """(n,) their numbers in the drawing."""
    piece: int | None = None
    """The piece that is left out; None is none."""
    fits: int = 0
    misses: int = 0
    """Rays that should return tape and do not, and returns where no tape is drawn."""
    in_place: int = 0
    """Rays that see the piece where it is drawn."""
    through: int = 0
    """Rays that look there and do not see it."""
    beside: int = 0
    """Returns that lie beside it."""
    offsets: deque[float] = field(default_factory=lambda: deque(maxlen=REMEMBERED))
    """How far the last of them do [m], of those seen where the place was known best."""
    exactness: float = math.inf
    """How far what was seen there may be off, one standard deviation [m]."""

    def note(self, offsets: list[float]) -> None:
        """Note how far returns lie beside the piece [m], unless others are more exact."""
        spread = self.tracker.spread
        if AS_EXACT * spread < self.exactness:
            self.exactness = spread
            self.offsets.clear()
        if spread < AS_EXACT * self.exactness:
            self.offsets.extend(offsets)


class Comparison(NamedTuple):
    """What one scan showed a follower."""

    missed: NDArray[np.intp]
    """The pieces that rays have missed, one for each ray."""
    beside: NDArray[np.intp]
    """The pieces that returns lie beside."""


class TapeDrawing:
    """The pieces of a drawing, and comparison of scans with it."""

    referenced = True
    """It never changes: states of a run that are stored share it."""

    def __init__(self, edges: Array) -> None:
        """Take edges (n, 4) [m] of tape."""
        self.pieces: tuple[TapePiece, ...] = pieces_of(edges)
        self._edges = edges
        self._index = index_edges(edges)
        self._owner = np.empty(len(edges), dtype=np.intp)
        for number, piece in enumerate(self.pieces):
            self._owner[piece.edges] = number
        self._across, self._long = normals(edges), lengths(edges)
        self._along = (edges[:, 2:] - edges[:, :2]) / self._long[:, None]

    def follower(self, pose: Pose2, covariance: Array, piece: int | None = None) -> PlaceFollower:
        """Return a follower from a pose on, by all tape or without a piece."""
        kept = np.arange(len(self._edges))
        if piece is not None:
            kept = np.delete(kept, self.pieces[piece].edges)
        tracker = PlaceTracker(self._edges[kept], pose, covariance)
        return PlaceFollower(tracker, self._across[kept], kept, piece)

    def look(self, follower: PlaceFollower, rays: Array) -> Comparison:
        """Count how rays (n, 9) fit where a follower is."""
        pose, piece = follower.tracker.pose, follower.piece
        seen, drawn = rays[:, column.RANGE], follower.tracker.expected(rays)
        fits, misses, odd = _compare(seen, drawn.ranges, _due(rays, drawn, pose, follower.across))
        for other in follower.tracker.others:
            # What fits from where the robot may be as well contradicts nothing.
            aside = follower.tracker.expected(rays, other)
            due = _due(rays, aside, other, follower.across)
            also_fits, also_misses, also_odd = _compare(seen, aside.ranges, due)
            contradicts = also_misses | also_odd
            fits, misses, odd = fits | also_fits, misses & contradicts, odd & contradicts
        follower.fits += int(fits.sum())
        follower.misses += int(misses.sum() + odd.sum())
        missed = self._owner[follower.edges[drawn.edges[misses]]]
        if piece is None:
            nearest, _ = self._beside(rays[odd], pose, follower.edges)
            return Comparison(missed, self._owner[nearest[nearest >= 0]])
        nearest, offset = self._beside(rays[odd], pose, self.pieces[piece].edges)
        own = nearest >= 0
        follower.misses -= int(own.sum())
        follower.beside += int(own.sum())
        if own.any():
            follower.note(offset[own].tolist())
        meets, due = self._meets(rays, pose, drawn)
        in_place, _, _ = _compare(seen, meets, due)
        follower.in_place += int((due & in_place).sum())
        follower.through += int((due & ~in_place).sum())
        return Comparison(missed, np.full(int(own.sum()), piece))

    def hidden_from(self, follower: PlaceFollower, rays: Array, pose: Pose2) -> Array:
        """Return where on rays (n, 9) the piece may lie, drawn or seen [m]; inf if nowhere."""
        drawn = follower.tracker.expected(rays, pose, FAR)
        result, _ = self._meets(rays, pose, drawn, FAR)
        none_due = np.zeros(len(rays), np.bool_)
        _, _, odd = _compare(rays[:, column.RANGE], drawn.ranges, none_due, FAR)
        assert follower.piece is not None
        nearest, _ = self._beside(rays[odd], pose, self.pieces[follower.piece].edges)
        own = np.flatnonzero(odd)[nearest >= 0]
        result[own] = np.minimum(result[own], rays[own, column.RANGE])
        return result

    def _meets(
        self, rays: Array, pose: Pose2, others: Expected, reach: float = REACH
    ) -> tuple[Array, Rays]:
        """Return where rays meet what is left out (n,) [m], else inf, and which must see it."""
        whole = expect(pose, rays, self._index, reach)
        first = whole.ranges < others.ranges
        due = first & _due(rays, whole, pose, self._across)
        return np.where(first, whole.ranges, np.inf), due

    def _beside(
        self, rays: Array, pose: Pose2, edges: NDArray[np.intp]
    ) -> tuple[NDArray[np.intp], Array]:
        """Return beside which of some edges returns lie, -1 for none, and how far [m]."""
        if not len(rays):
            return np.empty(0, dtype=np.intp), np.empty(0)
        starts, ways = rays[:, [column.X, column.Y]], heading_vectors(rays[:, column.DIRECTION])
        points = pose.apply(starts + ways * rays[:, column.RANGE, None])
        apart = points[:, None] - self._edges[None, edges, :2]
        along = np.einsum("ijk,jk->ij", apart, self._along[edges])
        aside = np.einsum("ijk,jk->ij", apart, self._across[edges])
        towards = heading_vectors(pose.theta + rays[:, column.DIRECTION])
        beside = (along > -BEYOND) & (along < self._long[edges] + BEYOND)
        beside &= (np.abs(aside) < BESIDE) & (towards @ self._across[edges].T < 0)
        distance = np.where(beside, np.abs(aside), np.inf)
        nearest, each = np.argmin(distance, axis=1), np.arange(len(rays))
        is_beside = np.isfinite(distance[each, nearest])
        return np.where(is_beside, edges[nearest], -1), aside[each, nearest]


def _due(rays: Array, expected: Expected, pose: Pose2, across: Array) -> Rays:
    """Return which rays (n,) must see the tape that they meet, if it is there."""
    ranges = expected.ranges
    clear = ~np.isfinite(rays[:, column.HIDDEN_FROM]) & (rays[:, column.CLEAR] > CLEAR)
    within = (ranges > rays[:, column.NEAR] + MARGIN) & (ranges < rays[:, column.FAR] - MARGIN)
    towards = heading_vectors(pose.theta + rays[:, column.DIRECTION])
    steep = -(towards * across[expected.edges]).sum(axis=1) > STEEP
    result: Rays = clear & within & steep & (ranges < NEAR)
    return result


def _compare(
    seen: Array, expected: Array, due: Rays, near: float = NEAR
) -> tuple[Rays, Rays, Rays]:
    """Return which rays (n,) see what they should, which miss it, and which see something else."""
    hit = seen < near
    with np.errstate(invalid="ignore"):
        error = np.abs(seen - expected)
    fits = hit & (error < OFF + OFF_BY_RANGE2 * np.minimum(seen, 1.0) ** 2)
    misses = due & ~fits & (seen > expected + PASSES)
    odd = hit & ~fits & (seen < expected - OFF)
    return fits, misses, odd
