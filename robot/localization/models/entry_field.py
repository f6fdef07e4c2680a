"""A table of the distance to the nearest edge that a ray can meet, over the whole field.

A ray ends where it enters tape, so it only meets edges that face it. For each of eight directions,
the table holds the distance to the nearest edge that a ray in about this direction can meet from
the light side. Close to an edge, the distance has a sign, which is negative on the tape's side. So
it is linear across the edge, and bilinear interpolation is exact there, even with cells that are
much larger than the desired accuracy. The table jumps where the sign ends; a look-up there takes
absolute values.
"""

from __future__ import annotations

import math
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from robot.fields.edges import sample
from robot.fields.field import Field
from robot.geometry import Array, heading_vectors
from robot.localization.kernels.entry_planes import DIRECTIONS, planes

SAMPLE_M = 0.002
"""Distance between the points that represent an edge [m]; larger for larger cells."""
SIGNED_CELLS = 2.0
"""The distance has a sign up to this many cells from an edge; farther away it would jump."""
MOST_CELLS = 500_000
"""Largest table for one direction; fields that would need more get coarser cells."""
THREADS = 2
"""Directions computed at the same time; each needs up to 40 MB."""
KEPT = 2
"""Tables kept in memory: up to 32 MB each, which saves 0.2 s."""


@dataclass(frozen=True, eq=False)
class EntryField:
    """Distances [m] by direction, row (y) and column (x)."""

    distances: NDArray[np.float32] = field(repr=False)
    """(DIRECTIONS, h, w)"""
    origin: tuple[float, float]
    """x, y [m] of the table's first cell."""
    resolution: float
    """[m]"""
    max_distance: float
    """Largest distance in the table [m]; all larger ones count as this."""
    wanted_resolution: float
    """The requested resolution [m]; a large field gets a coarser one."""

    @cached_property
    def planes(self) -> NDArray[np.int32]:
        """The distances as words (DIRECTIONS, h, w) for fast look-ups (``entry_planes``)."""
        return planes(self.distances, self.resolution, self.max_distance)

    @classmethod
    def build(cls, taped: Field, *, resolution: float, max_distance: float) -> EntryField:
        """Return the table of a field; the last few are kept for the next run on the same field."""
        return _built(taped.edges.astype(np.float64).tobytes(), resolution, max_distance)


@lru_cache(maxsize=KEPT)
def _built(edges_as_bytes: bytes, resolution: float, max_distance: float) -> EntryField:
    """Compute the table of edges (n, 4)."""
    edges = np.frombuffer(edges_as_bytes).reshape(-1, 4)
    low = edges.reshape(-1, 2).min(axis=0) - max_distance
    high = edges.reshape(-1, 2).max(axis=0) + max_distance
    cell = max(resolution, math.sqrt(float(np.prod(high - low)) / MOST_CELLS))
    step = max(SAMPLE_M, cell / 3)
    points, normals = sample(edges, step)
    width, height = np.ceil((high - low) / cell).astype(int) + 1
    x = low[0] + cell * np.arange(width)
    y = low[1] + cell * np.arange(height)
    cells = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    turns = heading_vectors(np.linspace(0.0, 2 * math.pi, DIRECTIONS, endpoint=False))
    # A ray may be half a step off its direction in the table, and so meet edges that lie along
    # that direction. Without these, one ray in thirty would find no edge at the true pose.
    grazing = math.sin(math.pi / DIRECTIONS)

    def toward(turn: Array) -> NDArray[np.float32]:
        facing = normals @ turn < grazing
        if not facing.any():
            return np.full((height, width), max_distance, dtype=np.float32)
        tree = cKDTree(points[facing])
        signed = _distances(cells, tree, normals[facing], max_distance, cell, step)
        return signed.reshape(height, width).astype(np.float32)

    # The tree's own threads continue after an interruption, and read freed memory.
    with ThreadPoolExecutor(THREADS) as threads:
        table = np.stack(list(threads.map(toward, turns)))
    return EntryField(table, (float(low[0]), float(low[1])), cell, max_distance, resolution)


def _distances(
    cells: Array, tree: cKDTree, normals: Array, max_distance: float, cell: float, step: float
) -> Array:
    """Return distances [m] of cells (c, 2) from edges: points in a tree, with normals (p, 2)."""
    _, index = tree.query(cells, distance_upper_bound=max_distance)
    nearest = np.asarray(index)
    results = nearest < tree.n
    away = cells[results] - tree.data[nearest[results]]
    normal = normals[nearest[results]]
    across = (away * normal).sum(axis=1)
    along = np.abs(away[:, 0] * normal[:, 1] - away[:, 1] * normal[:, 0])
    # A point represents the piece of edge up to half a step on either side.
    past_end = np.maximum(along - step / 2, 0.0)
    exact = np.hypot(across, past_end)
    near = exact < SIGNED_CELLS * cell
    result = np.full(len(cells), max_distance)
    result[results] = np.where(near, np.copysign(exact, across), exact)
    return result
