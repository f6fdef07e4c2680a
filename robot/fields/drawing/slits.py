"""Closes slits: gaps in tape that are too narrow for any camera.

CAD programs draw a curve as many short lines that are not joined. Where two of them meet at an
angle, their ends gape by some tenths of a millimetre: no picture shows it, but each would be two
edges as long as the tape is wide.
"""

from __future__ import annotations

import shapely

WIDEST_M = 0.001
"""Narrower gaps are closed [m]: a pixel of the floor picture."""

_CORNER = 20.0
"""Corners down to 6 degrees come back as they were."""
_NOTICED = 1e-9
"""Where less is closed [m²], the area stays as it was, to the last digit."""


def without_slits(area: shapely.Geometry) -> shapely.Geometry:
    """Return an area [m] without gaps, and with all else as it was."""
    half = WIDEST_M / 2
    grown = shapely.buffer(area, half, join_style="mitre", mitre_limit=_CORNER)
    closed = shapely.buffer(grown, -half, join_style="mitre", mitre_limit=_CORNER)
    filled = shapely.union(area, closed)
    return filled if shapely.area(filled) - shapely.area(area) > _NOTICED else area
