"""Edges of tape: straight segments with tape on one side and floor on the other.

Edges are arrays (n, 4) of x0, y0, x1, y1 [m]. From the first point to the second, the tape (or a
wall of a ROS map) is on the left. So the normal that points to the floor is (dy, -dx) / length.
"""

from __future__ import annotations

import numpy as np
import shapely
from numpy.typing import NDArray

from robot.geometry import Array, wrap_angle

SHARP = 0.3
"""An outline that turns by more than this [rad] ends one edge and begins another."""


def lengths(edges: Array) -> Array:
    """Return the lengths (n,) [m] of edges (n, 4)."""
    return np.hypot(edges[:, 2] - edges[:, 0], edges[:, 3] - edges[:, 1])


def normals(edges: Array) -> Array:
    """Return unit vectors (n, 2) across edges (n, 4), from the tape to the floor."""
    across = np.column_stack([edges[:, 3] - edges[:, 1], edges[:, 0] - edges[:, 2]])
    return across / lengths(edges)[:, None]


def sample(edges: Array, step: float) -> tuple[Array, Array]:
    """Return points (m, 2) [m] along edges (n, 4), and the normals (m, 2) of their edges.

    Each edge is cut into equal parts not longer than the step [m]. The points are the middles of
    the parts, so none lies on a corner, and each represents about the same length.

    Raises:
        ValueError: the step is not a positive number.
    """
    if not 0 < step < np.inf:
        raise ValueError(f"the step along edges is {step} m; valid is more than 0")
    # Rounding must not turn an edge of exactly k steps into k + 1 parts.
    parts = np.maximum(np.ceil(lengths(edges) / step - 1e-9), 1).astype(np.intp)
    owner = np.repeat(np.arange(len(edges)), parts)
    rank = np.arange(len(owner)) - np.repeat(np.cumsum(parts) - parts, parts)
    fraction = ((rank + 0.5) / parts[owner])[:, None]
    points = edges[owner, :2] * (1 - fraction) + edges[owner, 2:] * fraction
    return points, normals(edges)[owner]


def outline(area: shapely.Geometry) -> Array:
    """Return the edges (n, 4) around one or more polygons; the area itself is the tape."""
    rings = shapely.get_rings(shapely.orient_polygons(shapely.get_parts(area)))
    points, ring = shapely.get_coordinates(rings, return_index=True)
    if len(points) < 2:
        return np.empty((0, 4))
    edges: Array = np.hstack([points[:-1], points[1:]])[ring[1:] == ring[:-1]]
    return edges


def followers(edges: Array) -> NDArray[np.intp]:
    """Return, for each of edges (n, 4), the edge (n,) that begins at its end; -1 if none does."""
    rounded = np.round(edges, 6).tolist()
    first = {(x, y): index for index, (x, y, _, _) in enumerate(rounded)}
    return np.array([first.get((x, y), -1) for _, _, x, y in rounded], dtype=np.intp)


def smooth_joints(edges: Array) -> tuple[NDArray[np.intp], NDArray[np.intp], Array]:
    """Return the smooth joints of outlines: edges (m,), their followers (m,), turns (m,) [rad]."""
    after = followers(edges)
    before = np.flatnonzero(after >= 0)
    after = after[before]
    headings = np.arctan2(edges[:, 3] - edges[:, 1], edges[:, 2] - edges[:, 0])
    turns = wrap_angle(headings[after] - headings[before])
    smooth = np.abs(turns) <= SHARP
    return before[smooth], after[smooth], turns[smooth]


def sharp_ends(edges: Array) -> NDArray[np.bool_]:
    """Return (n, 2) whether the outline ends, or turns sharply, at each edge's start and end."""
    before, after, _ = smooth_joints(edges)
    sharp = np.ones((len(edges), 2), dtype=bool)
    sharp[before, 1] = sharp[after, 0] = False
    return sharp


def bends(edges: Array) -> Array:
    """Return the angles (n, 2) [rad] from edges (n, 4) to the outline's tangent at start and end.

    The edges of a curve are its chords: each takes half of the turn at its joints. At a sharp end
    the angle is zero.
    """
    before, after, turns = smooth_joints(edges)
    turned = np.zeros((len(edges), 2))
    turned[before, 1], turned[after, 0] = 0.5 * turns, -0.5 * turns
    return turned
