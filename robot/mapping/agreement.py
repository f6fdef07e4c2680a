"""Says how much of the tape that was seen lies on a map, and which of it an edit has taken away."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from robot.geometry import Array
from robot.mapping.ends import RaysOnFloor
from robot.mapping.strokes import Stroke

GATE = 0.008
"""Edges farther from those of the map than this are not on it [m]. With 20 mm, 50 mm of tape that
were taken away at a corner were thought to be of the other side; edges of right maps lie within 1
mm."""
SPACING = 0.004
"""Distance of the points along strokes that edges are compared with [m]: half of ``GATE``."""
CELL = 0.1
"""Places are told apart by cells of a side [m]."""
LEAST_LOST = 10
"""So many edges that lay on a map, and lie on none of its strokes now, are no chance."""


@dataclass(frozen=True, eq=False)
class Agreement:
    """What an edited map says of the edges that were seen."""

    share: float
    """Of those that lay on the map as it was drawn, the ones that lie on it still; it may be more
    than 1."""
    lost: Array
    """(n, 2) places of tape that was seen and drawn, and is not in the map any more [m]."""

    @classmethod
    def of(
        cls, strokes: Sequence[Stroke], drawn: Sequence[Stroke], width: float, rays: RaysOnFloor
    ) -> Agreement:
        """Return it of strokes of a width [m] that people made of those that were drawn."""
        edges = np.vstack([rays.entry, rays.leaving])
        edges = edges[np.isfinite(edges).all(axis=1)]
        lie, lay = _lie_on(strokes, width, edges), _lie_on(drawn, width, edges)
        cells, counts = np.unique(np.floor(edges[lay & ~lie] / CELL), axis=0, return_counts=True)
        lost = cells[counts >= LEAST_LOST][np.argsort(-counts[counts >= LEAST_LOST], kind="stable")]
        return cls(float(lie.sum() / max(1, lay.sum())), (lost + 0.5) * CELL)


def _lie_on(strokes: Sequence[Stroke], width: float, edges: Array) -> NDArray[np.bool_]:
    """Return which edges (n, 2) lie on those of strokes (n,)."""
    points = np.vstack([stroke.sampled(SPACING) for stroke in strokes])
    away, _ = cKDTree(points).query(edges, distance_upper_bound=width / 2 + GATE)
    on_edge: NDArray[np.bool_] = np.abs(away - width / 2) < GATE
    return on_edge
