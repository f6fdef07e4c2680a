"""Closes slits: gaps in tape that are too narrow for any camera.

CAD programs draw a curve as many short lines that are not joined. Where two of them meet at an
angle, their ends gape by some tenths of a millimetre: no picture shows it, but each would be two
edges as long as the tape is wide. A slit along two strips that lie side by side is another thing:
in a picture it parts them, and each is as wide as tape.
"""

from __future__ import annotations

import shapely

WIDEST_M = 0.001
"""Narrower gaps across tape are closed [m]: a pixel of the floor picture."""
ACROSS = 1.5
"""A slit across tape is no longer than this many widths of it."""
UNSEEN_M = 0.00025
"""Longer slits are closed if they are narrower [m]: of two strips of 5 cm the scanner sees those
that are 0.2 mm apart as one that is too wide for tape, and those 0.3 mm apart as two."""

_CORNER = 20.0
"""Corners down to 6 degrees come back as they were."""
_NOTICED = 1e-9
"""Where less is closed [m²], the area stays as it was, to the last digit."""


def without_slits(area: shapely.Geometry, width: float) -> shapely.Geometry:
    """Return the area [m] of tape of a width [m] without gaps, and with all else as it was."""
    half = WIDEST_M / 2
    grown = shapely.buffer(area, half, join_style="mitre", mitre_limit=_CORNER)
    closed = shapely.buffer(grown, -half, join_style="mitre", mitre_limit=_CORNER)
    filled = shapely.union(area, closed)
    slits = shapely.get_parts(shapely.difference(filled, area))
    lengths = shapely.length(slits) / 2
    seen = slits[(lengths > ACROSS * width) & (shapely.area(slits) > UNSEEN_M * lengths)]
    if len(seen):
        filled = shapely.difference(filled, shapely.union_all(seen))
    return filled if shapely.area(filled) - shapely.area(area) > _NOTICED else area
