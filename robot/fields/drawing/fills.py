"""The area inside outlines: SVG 2, chapter 13.4, fill rules."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import shapely
from numpy.typing import NDArray

from robot.geometry import Array


def fill_area(outlines: Sequence[Array], even_odd: bool) -> shapely.Geometry:
    """Return the area inside outlines, each (n, 2) and closed by a straight line if it is open.

    The outlines may cross each other and themselves. They are cut into faces. With ``even_odd``, a
    face is inside if the outlines wind around it an odd number of times. Without it, a face is
    inside if that number is not zero.
    """
    closed = [np.vstack([points, points[:1]]) for points in outlines if len(points) > 2]
    lines = shapely.union_all([shapely.LineString(points) for points in closed])
    faces = shapely.get_parts(shapely.polygonize([lines]))
    if not len(faces):
        return shapely.Polygon()
    inside = shapely.get_coordinates(shapely.point_on_surface(faces))
    winding = sum((_winding(points, inside) for points in closed), np.zeros(len(faces), np.int64))
    return shapely.union_all(faces[winding % 2 == 1 if even_odd else winding != 0])


def _winding(outline: Array, places: Array) -> NDArray[np.int64]:
    """Return how often a closed outline (n, 2) winds anticlockwise around points (m, 2).

    The winding number is the number of lines that cross a ray to the right of the point upward,
    minus those that cross it downward (Sunday 2001).
    """
    start, step = outline[:-1], np.diff(outline, axis=0)
    winding = np.zeros(len(places), np.int64)
    for i, (x, y) in enumerate(places):
        above = outline[:, 1] > y
        crossing = above[1:].astype(np.int64) - above[:-1]
        area = step[:, 0] * (y - start[:, 1]) - step[:, 1] * (x - start[:, 0])
        winding[i] = crossing[crossing * area > 0].sum()
    return winding
