"""Visibility of a field's edges: the parts that the line scanner can see.

The scanner's own judgement is applied to the map. Pairs of entry and exit are laid along the
outline of the tape as rays would meet them straight on, and ``judge_chain`` decides whether they
are tape. An edge that bends too tightly, is too short, or has no width of tape behind it counts as
blind: the scanner may see it from some poses and not from others.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from robot.compiling import compiled
from robot.fields.edge_index import EdgeIndex, index_edges
from robot.fields.edges import followers, lengths, sharp_ends
from robot.fields.ray_casting import cast_toward
from robot.geometry import Array
from robot.scanning.dashed_edges import SPAN
from robot.scanning.line_scanner import LineScannerSettings
from robot.scanning.tape import Tape
from robot.scanning.tape_edges import NEIGHBOURS, Limits, Verdict, judge_chain

STEP = 0.005
"""Largest length of the parts in which an edge is judged [m]."""
SPACING = 0.003
"""Distance of the pairs along the outline [m]."""
ASIDE = 0.3
"""Distance of the rays' start from the edge, off the tape [m]."""
BORDER = 0.010
"""Parts within this distance of a blind part are blind too, as rays also come from aside [m]."""

_COUNTED = int(Verdict.COUNTED)


class Visibility(NamedTuple):
    """Which parts of the edges are seen; compiled functions use it directly."""

    ends: NDArray[np.bool_]
    """(n, 2) whether the outline ends, or turns sharply, at each edge's start and end."""
    starts: NDArray[np.int64]
    """(n + 1,) index of the first part of each edge; an edge is cut into equal parts."""
    seen: NDArray[np.bool_]
    """(m,) whether the scanner sees each part."""
    support: float
    """Length of an edge that neighbouring rays must meet for the scanner to see it [m]."""
    inward: EdgeIndex
    """The edges the other way round: rays meet them where they leave tape."""


def visibility(
    edges: Array, tape: tuple[Tape, ...], settings: LineScannerSettings | None = None
) -> Visibility:
    """Return the visibility of edges (n, 4) around some kinds of tape.

    Without tape, the edges are walls, and all of them are seen.
    """
    ends = sharp_ends(edges)
    inward = index_edges(np.ascontiguousarray(edges[:, [2, 3, 0, 1]]))
    if not tape:
        all_seen = np.ones(len(edges), dtype=np.bool_)
        return Visibility(ends, np.arange(len(edges) + 1), all_seen, 0.0, inward)
    rules = settings or LineScannerSettings()
    parts = np.maximum(np.ceil(lengths(edges) / STEP - 1e-9), 1).astype(np.int64)
    starts = np.concatenate([[0], np.cumsum(parts)])
    after = followers(edges)
    before = np.full(len(edges), -1)
    before[after[after >= 0]] = np.flatnonzero(after >= 0)
    seen = np.zeros(starts[-1], dtype=np.bool_)
    for widths, support in _kinds(tape, rules.support):
        limits = (
            widths,
            rules.width_tolerance,
            support,
            rules.straightness,
            rules.taper,
            rules.bend_radius,
        )
        seen |= _judge_parts(edges, starts, before, after, inward, limits)
    seen = _without_border(seen, starts, edges, before, after)
    return Visibility(ends, starts, seen, rules.support, inward)


def _kinds(tape: tuple[Tape, ...], support: float) -> Iterator[tuple[Array, float]]:
    """Yield the widths of tape without gaps, then those of dashes, with the edge they need [m]."""
    solid = sorted({kind.width for kind in tape if not kind.dash})
    if solid:
        yield np.array(solid), support
    for kind in tape:
        if kind.dash:
            yield np.array([kind.width]), min(support, SPAN * kind.dash)


@compiled()
def _judge_parts(
    edges: Array,
    starts: NDArray[np.int64],
    before: NDArray[np.int64],
    after: NDArray[np.int64],
    inward: EdgeIndex,
    limits: Limits,
) -> NDArray[np.bool_]:
    seen = np.zeros(starts[-1], dtype=np.bool_)
    chain = np.empty((2 * NEIGHBOURS + 1, 4))
    curve = np.empty(6)
    support = limits[2]
    for edge in range(len(edges)):
        x0, y0, x1, y1 = edges[edge]
        length = math.hypot(x1 - x0, y1 - y0)
        count = starts[edge + 1] - starts[edge]
        # The floor is on the right in the direction of an edge.
        away_x, away_y = ASIDE * (y1 - y0) / length, -ASIDE * (x1 - x0) / length
        for part in range(count):
            along = (part + 0.5) / count * length
            x = x0 + (x1 - x0) * along / length + away_x
            y = y0 + (y1 - y0) * along / length + away_y
            left = _sample_outline(
                edges, edge, along, -1, before, after, x, y, support, inward, chain
            )
            right = _sample_outline(
                edges, edge, along, 1, before, after, x, y, support, inward, chain
            )
            verdict, _ = judge_chain(chain, left, right, limits, curve)
            seen[starts[edge] + part] = verdict == _COUNTED
    return seen


@compiled()
def _sample_outline(
    edges: Array,
    edge: int,
    along: float,
    way: int,
    before: NDArray[np.int64],
    after: NDArray[np.int64],
    x: float,
    y: float,
    support: float,
    inward: EdgeIndex,
    chain: Array,
) -> int:
    """Lay pairs along the outline to one side, seen from (x, y); return how many."""
    for count in range(NEIGHBOURS + 1):
        x0, y0, x1, y1 = edges[edge]
        length = math.hypot(x1 - x0, y1 - y0)
        tx, ty = (x1 - x0) / length, (y1 - y0) / length
        position = NEIGHBOURS + way * count
        px, py = x0 + along * tx, y0 + along * ty
        # The ray goes into the tape, which is on the left.
        deep, _ = cast_toward(px - 1e-7 * ty, py + 1e-7 * tx, -ty, tx, inward, 1.0)
        chain[position, 0], chain[position, 1] = px - x, py - y
        chain[position, 2], chain[position, 3] = px - deep * ty - x, py + deep * tx - y
        if count * SPACING >= support:
            return count
        along += way * SPACING
        while along < 0 or along > length:
            following = after[edge] if way > 0 else before[edge]
            if following < 0:
                return count
            along = along - length if way > 0 else along
            edge = following
            x0, y0, x1, y1 = edges[edge]
            length = math.hypot(x1 - x0, y1 - y0)
            along = along if way > 0 else along + length
    return NEIGHBOURS


@compiled()
def _without_border(
    seen: NDArray[np.bool_],
    starts: NDArray[np.int64],
    edges: Array,
    before: NDArray[np.int64],
    after: NDArray[np.int64],
) -> NDArray[np.bool_]:
    """Return which parts are seen, without those that lie within ``BORDER`` of a blind one."""
    kept = seen.copy()
    for edge in range(len(edges)):
        for part in range(starts[edge], starts[edge + 1]):
            if not seen[part]:
                _blind_beside(edge, part, -1, starts, edges, before, kept)
                _blind_beside(edge, part, 1, starts, edges, after, kept)
    return kept


@compiled()
def _blind_beside(
    edge: int,
    part: int,
    way: int,
    starts: NDArray[np.int64],
    edges: Array,
    following: NDArray[np.int64],
    kept: NDArray[np.bool_],
) -> None:
    gone = 0.0
    while gone < BORDER:
        part += way
        if not starts[edge] <= part < starts[edge + 1]:
            edge = following[edge]
            if edge < 0:
                return
            part = starts[edge] if way > 0 else starts[edge + 1] - 1
        kept[part] = False
        x0, y0, x1, y1 = edges[edge]
        gone += math.hypot(x1 - x0, y1 - y0) / (starts[edge + 1] - starts[edge])
