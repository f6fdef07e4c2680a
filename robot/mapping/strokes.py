"""Strokes of tape: the centre lines of a map that is not known yet, and their edges."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from robot.calibration.tape_edges import END, TapeEdges
from robot.fields.edges import normals
from robot.geometry import Array

if TYPE_CHECKING:
    from scipy.interpolate import CubicSpline

FINE = 5e-5
"""Curves are divided into lines that lie at most about this far beside them [m]."""
NODES_NEAR = 12
"""A place on a curve depends on this many nodes. If a node farther off moves, the place moves by
less than a thousandth of that."""
LEAST_SPAN = 0.02
"""A curve that goes on for longer than this gets one more node [m]."""
OVERLAP = 0.002
"""The edges of neighbouring lines of a curve overlap by this [m]."""


@dataclass(frozen=True, eq=False)
class Stroke:
    """The centre line of a piece of tape."""

    nodes: Array
    """(n, 2) [m] in the map; a closed stroke does not repeat its first one."""
    curved: bool = False
    """Whether a cubic spline leads through the nodes; else it is a line between two."""
    closed: bool = False
    light: bool = False
    """Whether its tape is lighter than the floor."""
    by_hand: bool = False
    """Whether a person has put an end of it where it is, or joined it."""

    @property
    def length(self) -> float:
        """From the first to the last node, along the stroke [m]."""
        return float(np.hypot(*np.diff(self.points, axis=0).T).sum())

    @property
    def points(self) -> Array:
        """(m, 2) along the stroke, close together where it bends; a closed one comes back."""
        return self.weights @ self.nodes

    def sampled(self, spacing: float) -> Array:
        """Return points (m, 2) along the stroke, about a distance apart [m]."""
        walked = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(self.points, axis=0).T))])
        places = np.linspace(0.0, walked[-1], 2 + round(walked[-1] / spacing))
        return np.column_stack([np.interp(places, walked, axis) for axis in self.points.T])

    @cached_property
    def knots(self) -> Array:
        """(n,) where the nodes are, or (n + 1,) of a closed stroke: sums of chords [m]."""
        around = np.vstack([self.nodes, self.nodes[:1]]) if self.closed else self.nodes
        return np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(around, axis=0).T))])

    @cached_property
    def across(self) -> Array:
        """(n, 2) unit vectors to the left of the stroke at its nodes."""
        if self.curved:
            along = self.spline(self.nodes)(self.knots[: len(self.nodes)], 1)
        else:
            along = np.tile(self.nodes[1] - self.nodes[0], (2, 1))
        left = np.column_stack([-along[:, 1], along[:, 0]])
        unit: Array = left / np.hypot(*left.T)[:, None]
        return unit

    @cached_property
    def weights(self) -> Array:
        """(m, n) share of each node in each of the points."""
        if not self.curved:
            return np.eye(2)
        shares: Array = self.spline(np.eye(len(self.nodes)))(self.places)
        return shares

    @cached_property
    def shares(self) -> tuple[NDArray[np.intp], Array, Array]:
        """Which nodes (m - 1, w) each line between two points depends on, and how much.

        The shares (m - 1, w) of the nodes in its start, and those in its end; 0 fills a row.
        """
        count = len(self.nodes)
        span = np.searchsorted(self.knots, self.places[:-1], side="right") - 1
        first = span - NODES_NEAR // 2 + 1
        if count <= NODES_NEAR:
            first = np.zeros_like(span)
        elif not self.closed:
            first = np.clip(first, 0, count - NODES_NEAR)
        near = first[:, None] + np.arange(NODES_NEAR)
        real = np.arange(NODES_NEAR) < count
        near = np.where(real, near % count, 0)
        line = np.arange(len(span))[:, None]
        start, end = (
            real * weights[line, near] for weights in (self.weights[:-1], self.weights[1:])
        )
        return near, start, end

    @cached_property
    def places(self) -> Array:
        """(m,) where the points are, as sums of chords [m]."""
        if not self.curved:
            return self.knots
        # Between two knots the second derivative is largest at one of them.
        bend = np.hypot(*self.spline(self.nodes)(self.knots, 2).T)
        spans = np.diff(self.knots)
        parts = np.ceil(spans * np.sqrt(np.maximum(bend[1:], bend[:-1]) / (8 * FINE)))
        places = [
            np.linspace(start, end, max(1, int(count)), endpoint=False)
            for start, end, count in zip(self.knots, self.knots[1:], parts, strict=False)
        ]
        return np.concatenate([*places, self.knots[-1:]])

    def with_end(self, last: bool, further: float) -> Stroke:
        """Return the stroke with one end moved outward by a length [m]; inward if negative."""
        if not last:
            return self.reversed.with_end(True, further).reversed
        if self.curved and further < 0:
            place = max(self.knots[-1] + further, self.knots[1] / 2)
            kept = self.nodes[self.knots < place - 0.2 * self.knots[1]]
            return replace(self, nodes=np.vstack([kept, self.spline(self.nodes)(place)]))
        end, outward = self.end(last)
        beyond = end + further * outward
        if self.curved and further > LEAST_SPAN:
            return replace(self, nodes=np.vstack([self.nodes, beyond]))
        return replace(self, nodes=np.vstack([self.nodes[:-1], beyond]))

    @property
    def reversed(self) -> Stroke:
        """The same stroke from its other end."""
        return replace(self, nodes=self.nodes[::-1])

    def end(self, last: bool) -> tuple[Array, Array]:
        """Return the first or last point, and the unit vector outward there, (2,) each."""
        if self.curved:
            along = self.spline(self.nodes)(self.knots[-1] if last else 0.0, 1)
        else:
            along = self.nodes[1] - self.nodes[0]
        outward = along if last else -along
        return self.nodes[-1 if last else 0], outward / math.hypot(*outward)

    def spline(self, values: Array) -> CubicSpline:
        """Return the spline through values (n, k) at the nodes."""
        # Most programs draw no map: 14 MB, and a tenth of a second at each start.
        from scipy.interpolate import CubicSpline  # noqa: PLC0415

        if self.closed:
            return CubicSpline(self.knots, np.vstack([values, values[:1]]), bc_type="periodic")
        return CubicSpline(self.knots, values, bc_type="not-a-knot")


@dataclass(frozen=True, eq=False)
class StrokeEdges(TapeEdges):
    """The edges of strokes; an unknown of each node is how far it lies beside where it was drawn.

    Along the tape a node would be free to move.
    """

    nodes: NDArray[np.intp] = field(repr=False)
    """(m, w) the nodes on which the place of an edge depends."""
    start_shares: Array = field(repr=False)
    """(m, w) share of each of them in the start of the edge; 0 fills the row."""
    end_shares: Array = field(repr=False)
    """(m, w) and in its end."""
    across: Array = field(repr=False)
    """(n, 2) unit vectors along which the nodes move."""
    stroke: NDArray[np.intp] = field(repr=False)
    """(m,) to which stroke an edge belongs."""
    places: Array = field(repr=False)
    """(m, 2) where on its stroke an edge starts and ends, as sums of chords (``Stroke.knots``)."""

    @property
    def on_left(self) -> NDArray[np.bool_]:
        """(m,) which edges lie on the left of their strokes."""
        left: NDArray[np.bool_] = self.places[:, 1] < self.places[:, 0]
        return left

    def place(self, edge: NDArray[np.int64], points: Array) -> Array:
        """Return where on their strokes points (n, 2) lie (n,) [m]."""
        part = self._part(edge, points)
        along: Array = self.places[edge, 0] * (1 - part) + self.places[edge, 1] * part
        return along

    @property
    def unknowns(self) -> int:
        """One for each node."""
        return len(self.across)

    def derivatives(self, edge: NDArray[np.int64], points: Array) -> tuple[NDArray[np.intp], Array]:
        """Return by which unknowns the distances of points change (n, w), and how much (n, w)."""
        part = self._part(edge, points)[:, None]
        shares = self.start_shares[edge] * (1 - part) + self.end_shares[edge] * part
        nodes = self.nodes[edge]
        normals, across = self.normals[edge], self.across[nodes]
        aside = across[..., 0] * normals[:, :1] + across[..., 1] * normals[:, 1:]
        return nodes, -shares * aside

    def _part(self, edge: NDArray[np.int64], points: Array) -> Array:
        """Return at which part of an edge's length points lie (n,)."""
        start = self.edges[edge, :2]
        along = self.edges[edge, 2:] - start
        part: Array = ((points - start) * along).sum(axis=1) / (along**2).sum(axis=1)
        return part


@dataclass(frozen=True, eq=False)
class Strokes:
    """All strokes of a map, as they were traced, and how far their nodes were moved since."""

    traced: tuple[Stroke, ...]
    width: float
    """Of the tape [m]."""
    offsets: Array
    """(n,) how far each node was moved to the left [m]."""

    @classmethod
    def of(cls, traced: Sequence[Stroke], width: float) -> Strokes:
        """Return strokes that lie where they were traced."""
        return cls(tuple(traced), width, np.zeros(sum(len(stroke.nodes) for stroke in traced)))

    @cached_property
    def each(self) -> tuple[Stroke, ...]:
        """The strokes, moved."""
        ends = np.cumsum([len(stroke.nodes) for stroke in self.traced])
        return tuple(
            replace(
                stroke,
                nodes=stroke.nodes
                + self.offsets[end - len(stroke.nodes) : end, None] * stroke.across,
            )
            for stroke, end in zip(self.traced, ends, strict=True)
        )

    @property
    def bends(self) -> Array:
        """(b, n) shares of the nodes' offsets in how much further strokes bend at inner nodes."""
        first, rows = 0, [np.zeros((0, len(self.offsets)))]
        for stroke in self.traced:
            count = len(stroke.nodes)
            own = np.zeros((max(0, count - 2), len(self.offsets)))
            inner = np.arange(len(own))
            for shift, share in enumerate((-0.5, 1.0, -0.5)):
                own[inner, first + inner + shift] = share
            rows.append(own)
            first += count
        return np.vstack(rows)

    def moved_by(self, offsets: Array) -> Strokes:
        """Return the same strokes, moved (n,) to the left of where they were traced [m]."""
        return replace(self, offsets=offsets)

    @property
    def edges(self) -> StrokeEdges:
        """Both edges of all strokes."""
        first = 0
        edges, margins = [np.zeros((0, 4))], [np.zeros((0, 2))]
        nodes = [np.zeros((0, NODES_NEAR), np.intp)]
        starts, ends = [np.zeros((0, NODES_NEAR))], [np.zeros((0, NODES_NEAR))]
        stroke, places = [np.zeros(0, np.intp)], [np.zeros((0, 2))]
        for number, (traced, moved) in enumerate(zip(self.traced, self.each, strict=True)):
            # The curve as it was traced says how much each node counts.
            points = traced.weights @ moved.nodes
            near, start, end = traced.shares
            nodes += 2 * [first + near]
            starts += [start, end]
            ends += [end, start]
            first += len(moved.nodes)
            aside = self.width / 2 * _across(points, traced.closed)
            right, left = points - aside, points + aside
            edges += [np.hstack([right[:-1], right[1:]]), np.hstack([left[1:], left[:-1]])]
            ahead = np.full((len(points) - 1, 2), -OVERLAP)
            if not traced.closed:
                length = float(np.hypot(*np.diff(points, axis=0).T).sum())
                ahead[0, 0] = ahead[-1, 1] = min(END, 0.25 * length)
            margins += [ahead, ahead[:, ::-1]]
            spans = np.column_stack([traced.places[:-1], traced.places[1:]])
            places += [spans, spans[:, ::-1]]
            stroke.append(np.full(2 * len(spans), number, np.intp))
        across = np.vstack([np.zeros((0, 2)), *(stroke.across for stroke in self.traced)])
        both = np.vstack(edges)
        return StrokeEdges(
            both,
            normals(both),
            np.vstack(margins),
            np.vstack(nodes),
            np.vstack(starts),
            np.vstack(ends),
            across,
            np.concatenate(stroke),
            np.vstack(places),
        )


def _across(points: Array, closed: bool) -> Array:
    """Return vectors (m, 2) to the left of a line through points, as long as keeps its width."""
    along = np.diff(points, axis=0)
    along /= np.hypot(*along.T)[:, None]
    ends = (along[-1:], along[:1]) if closed else (along[:1], along[-1:])
    before, after = np.vstack([ends[0], along]), np.vstack([along, ends[1]])
    both = before + after
    # A miter: at a bend, the edges' corners lie farther out than their lines.
    both /= (both * after).sum(axis=1)[:, None]
    return np.column_stack([-both[:, 1], both[:, 0]])
