"""Edits that people make to a finished map: strokes left out, moved at an end, or joined."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import product

from robot.geometry import Array
from robot.mapping.ends import End
from robot.mapping.joining import EndName, join
from robot.mapping.stroke_fitting import SHORTEST
from robot.mapping.strokes import Stroke
from robot.mapping.tidying import TidyStrokes, renumbered


def without_stroke(tidy: TidyStrokes, number: int) -> TidyStrokes:
    """Return strokes without one of them; what met it in a corner ends there as it is.

    Raises:
        ValueError: there is no other.
    """
    if len(tidy.strokes) == 1:
        raise ValueError("a map needs at least one stroke; discard the map instead")
    strokes = tidy.strokes[:number] + tidy.strokes[number + 1 :]
    kept = [k for k in range(len(tidy.strokes)) if k != number]
    return TidyStrokes(strokes, *renumbered(kept, tidy.corners, tidy.ends))


def with_moved_end(tidy: TidyStrokes, name: EndName, place: Array) -> TidyStrokes:
    """Return strokes with one end of a stroke at another place (2,) [m]; a corner there opens.

    Raises:
        ValueError: the stroke has no ends, or it would be too short.
    """
    number, last = name
    stroke = tidy.strokes[number]
    if stroke.closed:
        raise ValueError("a ring has no ends")
    nodes = stroke.nodes.copy()
    nodes[-1 if last else 0] = place
    moved = replace(stroke, nodes=nodes, by_hand=True)
    if math.dist(nodes[0], nodes[-1]) < SHORTEST:
        raise ValueError(f"a stroke is at least {1e3 * SHORTEST:.0f} mm long")
    strokes = (*tidy.strokes[:number], moved, *tidy.strokes[number + 1 :])
    corners = tuple(pair for pair in tidy.corners if name not in pair)
    freed = {end for pair in tidy.corners if name in pair for end in pair}
    ends = tidy.ends | {end: _given_end(strokes[end[0]], end[1]) for end in freed | {name}}
    return TidyStrokes(strokes, corners, ends)


def with_joined(tidy: TidyStrokes, number: int, other: int) -> TidyStrokes:
    """Return strokes with two of them as one, joined where their ends are nearest.

    Raises:
        ValueError: one of them has no ends, or they are the same.
    """
    if number == other:
        raise ValueError("a stroke cannot be joined to itself")
    if tidy.strokes[number].closed or tidy.strokes[other].closed:
        raise ValueError("a ring has no ends")
    a_last, b_last = min(
        product((False, True), repeat=2),
        key=lambda ends: math.dist(
            tidy.strokes[number].end(ends[0])[0], tidy.strokes[other].end(ends[1])[0]
        ),
    )
    before = tidy.strokes[number] if a_last else tidy.strokes[number].reversed
    after = tidy.strokes[other].reversed if b_last else tidy.strokes[other]
    names = {(number, not a_last): (number, False), (other, not b_last): (number, True)}
    gone = {(number, a_last), (other, b_last)}
    strokes = list(tidy.strokes)
    strokes[number] = replace(join(before, after), by_hand=True)
    corners = [(names.get(a, a), names.get(b, b)) for a, b in tidy.corners if not gone & {a, b}]
    freed = {end for pair in tidy.corners if gone & set(pair) for end in pair} - gone
    ends = {names.get(name, name): end for name, end in tidy.ends.items() if name not in gone}
    ends |= {names.get(name, name): _given_end(tidy.strokes[name[0]], name[1]) for name in freed}
    kept = [k for k in range(len(strokes)) if k != other]
    return TidyStrokes(tuple(strokes[k] for k in kept), *renumbered(kept, tuple(corners), ends))


def _given_end(stroke: Stroke, last: bool) -> End:
    """Return an end where somebody has put it."""
    return End(*stroke.end(last), 0.0, 0.0, math.nan)
