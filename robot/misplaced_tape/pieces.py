"""Pieces of tape: the edges of a drawing that belong together."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from robot.fields.edges import lengths, normals, smooth_joints
from robot.geometry import Array

WIDEST = 0.07
"""Two edges farther apart are not the sides of one strip of tape [m]: tape is 5 cm wide."""
NARROWEST = 0.01
"""Two edges nearer than this are not, either [m]."""
OPPOSITE = -0.95
"""Largest cosine between the normals of the two sides."""
SHORTEST = 0.08
"""An edge shorter than this is an end of a strip, not a side of it [m]."""


@dataclass(frozen=True, eq=False)
class TapePiece:
    """A strip of tape, straight or bent smoothly."""

    edges: NDArray[np.intp]
    """(k,) their numbers in the drawing."""
    middle: tuple[float, float]
    """Of its box [m], in the map."""
    length: float
    """Of its longer side [m]."""


def pieces_of(edges: Array) -> tuple[TapePiece, ...]:
    """Return the pieces that edges (n, 4) [m] consist of; each edge belongs to one."""
    before, after, _ = smooth_joints(edges)
    left, right = _sides(edges)
    pairs = np.concatenate([before, left]), np.concatenate([after, right])
    count = len(edges)
    graph = coo_array((np.ones(len(pairs[0])), pairs), shape=(count, count))
    number, owner = connected_components(graph, directed=False)
    long = lengths(edges)
    result = []
    for each in range(number):
        members = np.flatnonzero(owner == each)
        points = edges[members].reshape(-1, 2)
        x, y = ((points.min(axis=0) + points.max(axis=0)) / 2).tolist()
        length = float(long[members].sum() / (2 if _is_strip(members, left) else 1))
        result.append(TapePiece(members, (x, y), length))
    return tuple(result)


def _is_strip(members: NDArray[np.intp], sides: NDArray[np.intp]) -> bool:
    return bool(np.isin(members, sides).any())


def _sides(edges: Array) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return pairs of edges (m,), (m,) that are the two sides of a strip."""
    across, long = normals(edges), lengths(edges)
    along = (edges[:, 2:] - edges[:, :2]) / long[:, None]
    middles = (edges[:, :2] + edges[:, 2:]) / 2
    sides = np.flatnonzero(long >= SHORTEST)
    # Row: the edge beside whose middle the column's edge passes.
    apart = middles[sides, None] - edges[None, :, :2]
    passed = np.einsum("ijk,jk->ij", apart, along)
    inside = -np.einsum("ijk,jk->ij", apart, across)
    beside = (passed >= 0) & (passed <= long) & (inside > NARROWEST) & (inside < WIDEST)
    beside &= across[sides] @ across.T < OPPOSITE
    first, second = np.nonzero(beside)
    return sides[first], second
