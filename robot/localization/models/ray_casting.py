"""Exact distances along rays to the edges of a field."""

from __future__ import annotations

import math

from numba import njit

from robot.geometry import Array


@njit(cache=True, nogil=True)
def cast_ray(x: float, y: float, heading: float, edges: Array, range_max: float) -> float:
    """Distance [m] to the first edge that is met from its light side; +inf beyond a range.

    Args:
        x: start of the ray [m].
        y: start of the ray [m].
        heading: direction of the ray [rad].
        edges: (n, 4) x0, y0, x1, y1 [m] with the dark side on the left.
        range_max: how far the ray reaches [m].
    """
    dx, dy = math.cos(heading), math.sin(heading)
    nearest = range_max
    found = False
    for i in range(len(edges)):
        x0, y0, x1, y1 = edges[i]
        ex, ey = x1 - x0, y1 - y0
        # Across the edge from light (its right) to dark (its left) this is negative.
        across = dx * ey - dy * ex
        if across >= 0:
            continue
        wx, wy = x0 - x, y0 - y
        along = (wx * ey - wy * ex) / across
        if not 0 <= along <= nearest:
            continue
        part = (wx * dy - wy * dx) / across
        if 0 <= part <= 1:
            nearest = along
            found = True
    return nearest if found else math.inf


@njit(cache=True, nogil=True)
def cast_rays(poses: Array, bearings: Array, edges: Array, range_max: float, result: Array) -> None:
    """Fill ``result`` (n, k) with the distances that a scan from poses (n, 3) would report."""
    for i in range(len(poses)):
        for j in range(len(bearings)):
            result[i, j] = cast_ray(
                poses[i, 0], poses[i, 1], poses[i, 2] + bearings[j], edges, range_max
            )
