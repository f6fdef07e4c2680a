"""Compiled conversions between positions along a ray, points on the floor and ranges."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from robot.compiling import compiled
from robot.geometry import Array

BEYOND = 0.1
"""An edge goes on unseen for this part of the angle between two rays. Half: 0.2 % fewer returns
of *square* (183 pictures by a robot that turns at 0.8 and at 1.8 rad/s), twice: 0.2 % more; the
same errors."""

APART = 0.003
"""What rays beside each other met lies on one edge if it is at most this far off its line [m]. On
the same pictures, returns err by 0.105 and 0.217 mm (rms). Half: by 0.097 and 0.214, and 0.1 % are
fewer; twice: by 0.107 and 0.326."""


@compiled()
def between(row: NDArray[np.floating], position: float) -> float:
    """Return the value of a row (m,) between samples, by the parabola through the nearest three."""
    i = min(max(int(position + 0.5), 1), len(row) - 2)
    part = position - i
    before, current, after = row[i - 1], row[i], row[i + 1]
    return float(current + 0.5 * part * (after - before + part * (before - 2 * current + after)))


@compiled()
def points_of(edges: Array, distances: Array, directions: Array) -> Array:
    """Convert pairs [samples] to points (k, p, 4) [m]: x and y of the entry, then of the exit.

    Args:
        edges: (k, p, 2) entry and exit along each ray [samples]; nan after the last pair.
        distances: (k, m) of the samples from the rays' centre [m].
        directions: (k, 2) unit vectors along the rays.
    """
    rays, pairs, _ = edges.shape
    points = np.full((rays, pairs, 4), np.nan)
    for ray in range(rays):
        dx, dy = directions[ray, 0], directions[ray, 1]
        for pair in range(pairs):
            if np.isnan(edges[ray, pair, 0]):
                break
            entry = between(distances[ray], edges[ray, pair, 0])
            leaving = between(distances[ray], edges[ray, pair, 1])
            points[ray, pair, 0], points[ray, pair, 1] = entry * dx, entry * dy
            points[ray, pair, 2], points[ray, pair, 3] = leaving * dx, leaving * dy
    return points


@compiled()
def ranges_of(
    lines: Array,
    pairs: Array,
    chosen: NDArray[np.int8],
    verdicts: NDArray[np.int8],
    distances: Array,
    directions: Array,
) -> tuple[Array, Array]:
    """Return where rays meet the lines of their edges.

    Args:
        lines: (k, 3) unit normal and offset [m] of the entry edges.
        pairs: (k, p, 2) entries and exits [samples].
        chosen: (k,) index of the pair of each ray.
        verdicts: (k,) zero for those that count.
        distances: (k, m) of the samples from the rays' centre [m].
        directions: (k, 2) unit vectors along the rays.

    Returns:
        Ranges (k,) [m], inf for rays that do not count, and for those that meet the line of their
        edge outside of what they see; chosen entries and exits (k, 2) [samples]. Entries that
        count are moved to the position of their range.
    """
    ranges = np.full(len(lines), np.inf)
    edges = np.empty((len(lines), 2))
    for ray in range(len(lines)):
        position, edges[ray, 1] = pairs[ray, chosen[ray], 0], pairs[ray, chosen[ray], 1]
        if verdicts[ray] == 0:
            facing = lines[ray, 0] * directions[ray, 0] + lines[ray, 1] * directions[ray, 1]
            reach = lines[ray, 2] / facing if facing != 0.0 else np.inf
            moved = _sample_at(reach, distances[ray], position)
            if moved >= 0.0:
                ranges[ray], position = reach, moved
        edges[ray, 0] = position
    return ranges, edges


@compiled()
def hidden_of(
    pairs: Array,
    single: Array,
    met: NDArray[np.int32],
    chosen: NDArray[np.int8],
    verdicts: NDArray[np.int8],
    distances: Array,
) -> Array:
    """Return from where to where something that is no tape lies on each ray (k, 2) [m].

    A shoe or a shadow may hide tape, or spoil its edge. Behind tape that counts, nothing is looked
    for. Without such a thing it is from inf to -inf.

    Args:
        pairs: (k, p, 2) entries and exits [samples].
        single: (k, 2) exit of something that the ray begins in, and entry of something in which it
            ends [samples]; nan without.
        met: (k,) number of edges that each ray met, two for each pair.
        chosen: (k,) index of the pair of each ray that counts.
        verdicts: (k,) zero for rays that count.
        distances: (k, m) of the samples from the rays' centre [m].
    """
    hidden = np.empty((len(met), 2))
    for ray in range(len(met)):
        begin, end = np.inf, -np.inf
        counts = verdicts[ray] == 0
        things = chosen[ray] if counts else met[ray] // 2
        if not np.isnan(single[ray, 0]):
            begin, end = 0.0, between(distances[ray], single[ray, 0])
        if things > 0:
            begin = min(begin, between(distances[ray], pairs[ray, 0, 0]))
            end = between(distances[ray], pairs[ray, things - 1, 1])
        if not counts and (not np.isnan(single[ray, 1]) or things == pairs.shape[1]):
            begin = min(begin, between(distances[ray], single[ray, 1])) if things == 0 else begin
            end = np.inf
        hidden[ray, 0], hidden[ray, 1] = begin, end
    return hidden


@compiled(inline="always")
def _sample_at(reach: float, distances: Array, position: float) -> float:
    """Return the position [samples] of a distance [m] along a ray, from one that is near; else -1.

    Three steps of Newton's method are exact to a nanometre.
    """
    for _ in range(3):
        slope = between(distances, position + 0.5) - between(distances, position - 0.5)
        if slope <= 0.0:
            return -1.0
        position += (reach - between(distances, position)) / slope
    return max(position, 0.0) if -1.0 < position < len(distances) else -1.0


@compiled()
def unskew(
    ranges: Array,
    sight: Array,
    lines: Array,
    edges: Array,
    late: Array,
    directions: Array,
    centre_x: float,
    v: float,
    omega: float,
) -> None:
    """Correct ranges and sight to those of a camera that exposes all rows at the frame's stamp.

    A row exposed dt after the stamp saw the floor from a robot that had moved on by v dt. In the
    frame at the stamp, the edge is farther by this motion. The edge is a line, so along the same
    bearing the range changes by (n . moved) / (n . direction). Where an edge ends, the last rays
    that met it look past it by then, and get inf. Where a ray's sight begins and ends moves in the
    same way: tape at the border of the picture would be expected, or not, a few millimetres wrong.

    Args:
        ranges: (k,) [m], changed in place.
        sight: (k, 2) nearest and farthest that each sees [m], changed in place; nan for nothing.
        lines: (k, 3) unit normal and offset of each edge.
        edges: (k, 2) positions of entries and exits [samples].
        late: (k, m) when each sample is exposed after the stamp [s], the last one repeated.
        directions: (k, 2) unit vectors along the rays.
        centre_x: where the rays start, ahead of the robot's origin [m].
        v: the robot's velocity [m/s].
        omega: its turning rate [rad/s].
    """
    seen = ranges.copy()
    for ray in range(len(ranges)):
        dx, dy = directions[ray]
        for end in range(2):
            x, y = sight[ray, end] * dx + centre_x, sight[ray, end] * dy
            sight[ray, end] += late[ray, -end] * (dx * (v - omega * y) + dy * omega * x)
        if np.isinf(seen[ray]):
            continue
        passed = between(late[ray], edges[ray, 0])
        nx, ny, _ = lines[ray]
        x, y = seen[ray] * dx + centre_x, seen[ray] * dy
        moved_x, moved_y = passed * (v - omega * y), passed * omega * x
        ranges[ray] += (nx * moved_x + ny * moved_y) / (nx * dx + ny * dy)
        aside = (dx * moved_y - dy * moved_x) / seen[ray]
        if not _is_seen(ray, aside, lines[ray], seen, directions):
            ranges[ray] = np.inf


@compiled()
def _is_seen(ray: int, aside: float, line: Array, seen: Array, directions: Array) -> bool:
    """Return whether a ray still meets what was seen of its edge, which has moved aside [rad].

    Behind a corner, the line of an edge alone gives returns that are up to 19 mm too far.
    """
    apart = directions[0, 0] * directions[1, 1] - directions[0, 1] * directions[1, 0]
    step = -1 if aside * apart > 0 else 1
    for count in range(1, math.ceil(abs(aside / apart) - BEYOND) + 1):
        beside = ray + step * count
        if 0 <= beside < len(seen):
            facing = line[0] * directions[beside, 0] + line[1] * directions[beside, 1]
            if not abs(seen[beside] * facing - line[2]) <= APART:  # nan and inf are not, either
                return False
    return True
