"""``walls_in``: what was said of walls, which an engine keeps and each tick shows."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from robot.navigation.walls import Polygon, Walls

WALLS = "walls"
"""Name in ``Controls.kept`` and ``Snapshot.added``."""
NOTHING_SAID = Walls()


def walls_in(kept: Mapping[str, object]) -> Walls:
    """Return what an engine, or a tick, has of walls."""
    said = kept.get(WALLS)
    return said if isinstance(said, Walls) else NOTHING_SAID


def polygons(zones: Iterable[Sequence[tuple[float, float]]]) -> tuple[Polygon, ...]:
    """Return zones of a command as they are kept."""
    return tuple(tuple((float(x), float(y)) for x, y in zone) for zone in zones)
