"""LaidTape: where tape lies that was laid by hand, beside its place in the drawing.

Each place on the tape is off by some millimetres, and places near each other by about the same: a
Gaussian process, told by its values at some points of the drawing, the centres. Besides, the whole
floor may be larger or smaller than its drawing.
"""

from __future__ import annotations

import math

import numpy as np

from robot.fields.edge_index import index_edges
from robot.fields.edges import lengths, sample
from robot.geometry import Array

LAID_SD, SCALE_SD = 0.010, 0.02
"""How far tape is off along each axis [m], and the floor's scale; standard deviations."""
LONGEST_PART = 0.2
"""Edges are cut into parts no longer than this [m]."""
APART, STEP = 0.15, 0.03
"""Centres are no nearer to each other than this [m]; they are chosen of points so far apart."""
ALIKE = 0.25
"""Places so far apart are off alike by exp(-1/2) [m]."""
JITTER = 1e-4
"""Of the centres' variance, for its inverse."""


class LaidTape:
    """Parts of the edges of a drawing, and how they move with the offsets of the centres.

    Offsets are (2 k + 1,): of k centres along x, then along y [m], and the scale less one.
    """

    referenced = True
    """It never changes: states of a run that are stored share it."""

    def __init__(self, edges: Array, *, scales: bool = True, bends: bool = True) -> None:
        """Take edges (n, 4) [m].

        Args:
            edges: of the drawing.
            scales: whether the floor may be larger or smaller than the drawing.
            bends: whether each place may be off by itself.
        """
        parts = _parts(edges)
        self.starts, self.ends = parts[:, :2], parts[:, 2:]
        """(m, 2) where each part starts and ends in the drawing [m]."""
        centres = _centres(sample(edges, STEP)[0]) if bends else np.empty((0, 2))
        between = _likeness(centres, centres) + JITTER * np.eye(len(centres))
        weights = np.linalg.inv(between)
        self.start_weights = _likeness(self.starts, centres) @ weights
        self.end_weights = _likeness(self.ends, centres) @ weights
        """(m, k) by how much of each centre's offset they move."""
        self.centres = centres
        """(k, 2) [m]."""
        count = len(centres)
        self.prior = np.zeros((2 * count + 1, 2 * count + 1))
        """Covariance of the offsets before anything was seen."""
        self.prior[:count, :count] = self.prior[count:-1, count:-1] = LAID_SD**2 * between
        self.prior[-1, -1] = SCALE_SD**2 if scales else 0.0
        self._information = np.linalg.pinv(self.prior, hermitian=True)
        self.drawn = index_edges(parts)
        """The parts where they are drawn."""

    def laid(self, offsets: Array) -> Array:
        """Return the parts (m, 4) [m] as they lie with these offsets."""
        shifts, scale = self.shifts(offsets), 1.0 + offsets[-1]
        return np.hstack(
            [
                scale * self.starts + self.start_weights @ shifts,
                scale * self.ends + self.end_weights @ shifts,
            ]
        )

    def unlikelihood(self, offsets: Array) -> float:
        """Return by how many standard deviations tape so laid is more unlikely than it may be."""
        # Fisher: the root of twice a chi-square is about normal.
        free = max(2 * int((self.prior.diagonal() > 0).sum()) - 1, 0)
        squared = float(offsets @ self._information @ offsets)
        return math.sqrt(2 * squared) - math.sqrt(free)

    def shifts(self, offsets: Array) -> Array:
        """Return the offsets of the centres (k, 2) [m], without the scale."""
        return offsets[:-1].reshape(2, -1).T


def _parts(edges: Array) -> Array:
    """Return the parts (m, 4) [m] of edges; none is longer than LONGEST_PART."""
    count = np.maximum(np.ceil(lengths(edges) / LONGEST_PART), 1).astype(np.intp)
    owner = np.repeat(np.arange(len(edges)), count)
    rank = np.arange(len(owner)) - np.repeat(np.cumsum(count) - count, count)
    begin, end = (rank / count[owner])[:, None], ((rank + 1) / count[owner])[:, None]
    first, last = edges[owner, :2], edges[owner, 2:]
    return np.hstack([first + begin * (last - first), first + end * (last - first)])


def _centres(points: Array) -> Array:
    """Return points (k, 2) that are spread over all points (n, 2), none near another."""
    chosen: list[Array] = []
    while len(points):
        chosen.append(points[0])
        points = points[np.hypot(*(points - points[0]).T) > APART]
    return np.array(chosen).reshape(-1, 2)


def _likeness(points: Array, others: Array) -> Array:
    """Return how much alike places (n, 2) and (m, 2) are off: (n, m), 1 for the same place."""
    squared = ((points[:, None] - others[None]) ** 2).sum(axis=2)
    alike: Array = np.exp(-squared / (2 * ALIKE**2))
    return alike
