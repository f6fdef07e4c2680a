"""Finds tape that was only seen along its length: rays meet its end, and leave it by its sides.

Such rays cross no tape by both edges at once, so the scanner does not count it. A stub that points
at the robot is seen so.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from robot.fields.drawing.curves import distances
from robot.geometry import Array
from robot.mapping.crossings import is_tape
from robot.mapping.ends import RaysOnFloor
from robot.mapping.strokes import Stroke

BEYOND, NEAR = 0.012, 0.3
"""Points farther than this from known tape [m] do not belong to it, if they are seen from this
distance [m]. From farther away, where a pixel is longer, the limit grows in proportion."""
LINK = 0.06
"""Points nearer to each other than this belong to one thing [m]; so both sides of tape do."""
FEWEST, FEWEST_PICTURES = 8, 3
"""Fewest points of a thing, and fewest pictures that saw it."""
SCATTER = 0.002
"""Standard deviation of a point [m]; those beyond twice that count less and less."""
CLOSE, FITTING = 0.004, 0.6
"""A thing is tape if at least the second, a share of its points, lies within the first of the
outline [m]."""
FEWEST_ON_SIDE = 3
"""Fewest points on each side of it."""


@dataclass(frozen=True, eq=False)
class Lengthwise:
    """What rays met that is not of known tape."""

    strokes: tuple[Stroke, ...]
    """Tape: from its end, or where its sides were seen first, to where they were seen last."""
    others: tuple[Array, ...]
    """Where rays met each other thing, (n, 2) [m]."""


def find_lengthwise(strokes: tuple[Stroke, ...], width: float, rays: RaysOnFloor) -> Lengthwise:
    """Return tape of a width [m] that is not among the known strokes."""
    met = np.isfinite(rays.first[:, 0])
    met[met] = _is_beyond(rays.first[met], rays.begin[met], strokes, width)
    # Tape that crosses known tape is left by its own sides.
    left = np.isfinite(rays.until[:, 0])
    left[left] = _is_beyond(rays.until[left], rays.begin[left], strokes, width)
    # Rays that begin in the dark meet no edge there.
    met &= np.hypot(*(rays.first - rays.begin).T) > 1e-3
    points = np.vstack([rays.first[met], rays.until[left]])
    picture = np.concatenate([rays.picture[met], rays.picture[left]])
    front = np.arange(len(points)) < met.sum()
    tape, others = [], []
    for thing in _things(points, picture):
        stroke = _fit(points[thing], front[thing], width)
        if stroke is None or not is_tape(stroke, width, rays):
            others.append(points[thing])
        else:
            tape.append(stroke)
    return Lengthwise(tuple(tape), tuple(others))


def _is_beyond(
    points: Array, begin: Array, strokes: tuple[Stroke, ...], width: float
) -> NDArray[np.bool_]:
    """Return which points (n, 2) [m], seen from others, are of no known tape."""
    seen_from = np.hypot(*(points - begin).T)
    beyond: NDArray[np.bool_] = _from_tape(points, strokes, width) > BEYOND * np.maximum(
        1.0, seen_from / NEAR
    )
    return beyond


def _from_tape(points: Array, strokes: tuple[Stroke, ...], width: float) -> Array:
    """Return how far points (n, 2) lie from tape (n,) [m]; on it, they are negative."""
    nearest = np.full(len(points), np.inf)
    for stroke in strokes:
        for start, end in pairwise(stroke.points):
            nearest = np.minimum(nearest, distances(points, start, end))
    return nearest - width / 2


def _things(points: Array, picture: NDArray[np.intp]) -> list[NDArray[np.intp]]:
    """Return which points (n, 2) belong together."""
    if not len(points):
        return []
    pairs = cKDTree(points).query_pairs(LINK, output_type="ndarray")
    links = coo_array((np.ones(len(pairs)), pairs.T), shape=(len(points), len(points)))
    count, thing = connected_components(links, directed=False)
    things = [np.flatnonzero(thing == number) for number in range(count)]
    return [
        members
        for members in things
        if len(members) >= FEWEST and len(np.unique(picture[members])) >= FEWEST_PICTURES
    ]


def _fit(points: Array, front: NDArray[np.bool_], width: float) -> Stroke | None:
    """Fit the outline of tape that ends: its end, and both sides.

    Args:
        points: (n, 2) [m].
        front: (n,) which of them rays met first.
        width: of the tape [m].

    Returns:
        None if it is no tape.
    """
    # Only the process that draws comes here; the page's own has no use for 10 MB of scipy.
    from scipy.optimize import least_squares  # noqa: PLC0415

    axes = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)[2]
    fits = []
    for inward in (axes[0], -axes[0], axes[1], -axes[1]):
        along = points @ inward
        begin = points.mean(axis=0) + (along.min() - along.mean()) * inward
        start = np.array([*begin, math.atan2(inward[1], inward[0])])
        fits.append(
            least_squares(
                _signed_distance, start, loss="cauchy", f_scale=2 * SCATTER, args=(points, width)
            )
        )
    best = min(fits, key=lambda fit: fit.cost)
    local = _local(best.x, points)
    close = np.abs(_signed_distance(best.x, points, width)) < CLOSE
    side = close & ~front & (local[:, 0] > CLOSE)
    counts = (side & (local[:, 1] > 0)).sum(), (side & (local[:, 1] < 0)).sum()
    if close.mean() < FITTING or min(counts) < FEWEST_ON_SIDE:
        return None
    inward = np.array([math.cos(best.x[2]), math.sin(best.x[2])])
    at_end = close & front & (np.abs(local[:, 0]) < CLOSE)
    begin = 0.0 if at_end.sum() >= FEWEST_ON_SIDE else local[side, 0].min()
    places = np.array([[begin], [local[side, 0].max()]])
    return Stroke(best.x[:2] + places * inward)


def _local(pose: Array, points: Array) -> Array:
    """Return points (n, 2) along and across tape whose end has a pose (3,)."""
    c, s = math.cos(pose[2]), math.sin(pose[2])
    away = points - pose[:2]
    return np.column_stack([away @ (c, s), away @ (-s, c)])


def _signed_distance(pose: Array, points: Array, width: float) -> Array:
    """Return how far points (n, 2) lie from the outline of tape whose end has a pose (3,) [m].

    Those inside are negative.
    """
    along, across = _local(pose, points).T
    aside = np.abs(across) - width / 2
    inside = np.maximum(aside, -along)
    outside = np.where(aside > 0, np.where(along > 0, aside, np.hypot(aside, along)), -along)
    distance: Array = np.where((along > 0) & (aside < 0), inside, outside)
    return distance
