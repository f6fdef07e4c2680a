"""The edges of tape that sightings are matched with, known from a drawing or still to be found."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from robot.fields.edges import lengths, normals
from robot.geometry import Array

END = 0.03
"""Edges are not measured nearer to their ends than this [m], as corners round them off."""


@dataclass(frozen=True, eq=False)
class TapeEdges:
    """Edges whose places are known."""

    edges: Array = field(repr=False)
    """(m, 4) [m], with the tape on their left."""
    normals: Array = field(repr=False)
    """(m, 2) toward the floor."""
    margins: Array = field(repr=False)
    """(m, 2) from the start and from the end of each edge [m]: nothing is measured within that."""

    @classmethod
    def of(cls, edges: Array) -> TapeEdges:
        """Return the edges (m, 4) of a drawing."""
        margins = np.minimum(END, 0.25 * lengths(edges))
        return cls(edges, normals(edges), np.column_stack([margins, margins]))

    @property
    def unknowns(self) -> int:
        """How many numbers of the map are not known."""
        return 0

    def derivatives(self, edge: NDArray[np.int64], points: Array) -> tuple[NDArray[np.intp], Array]:
        """Return the derivatives of the distances of points from edges, by the unknowns.

        A distance depends on a few unknowns only: their numbers (n, w), and the derivatives by
        them (n, w); the rest are zero.

        Args:
            edge: (n,) which edge each point belongs to.
            points: (n, 2) in the map [m].
        """
        return np.zeros((len(edge), 0), np.intp), np.zeros((len(edge), 0))
