"""Lines and arcs through flattened curves: within the tolerance, few, and the same way round."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.features.field_editor.arcs import TOLERANCE, Node, fitted
from robot.geometry import Array

FINE = 0.05
"""How far flattened curves are from the true ones [mm]."""
whole = st.integers(-2000, 2000)


def along(nodes: list[Node], *, closed: bool) -> Array:
    """Points along the lines and arcs of nodes: what SVG draws of them."""
    pairs = zip(nodes, nodes[1:] + nodes[:1] if closed else nodes[1:], strict=False)
    found = []
    for (ax, ay, bend), (bx, by, _) in pairs:
        share = np.linspace(0, 1, 40)[:, None]
        start, end = np.array([ax, ay]), np.array([bx, by])
        if bend == 0:
            found.append(start + share * (end - start))
            continue
        turn = 4 * math.atan(bend)
        chord = end - start
        left = np.array([-chord[1], chord[0]])
        centre = (start + end) / 2 + left / (2 * math.tan(turn / 2))
        spoke, angles = start - centre, turn * share[:, 0]
        turned = np.column_stack([
            np.cos(angles) * spoke[0] - np.sin(angles) * spoke[1],
            np.sin(angles) * spoke[0] + np.cos(angles) * spoke[1],
        ])  # fmt: skip
        found.append(centre + turned)
    return np.vstack(found)


def farthest(points: Array, chain: Array) -> float:
    """Largest distance of points from a chain of lines."""
    a, b = chain[:-1, None], chain[1:, None]
    step = b - a
    share = ((points - a) * step).sum(-1) / np.maximum((step**2).sum(-1), 1e-12)
    nearest = a + np.clip(share, 0, 1)[..., None] * step
    return float(np.hypot(*(points - nearest).transpose(2, 0, 1)).min(axis=0).max())


@given(st.lists(st.tuples(whole, whole), min_size=2, max_size=12, unique=True), st.booleans())
def test_corners_are_kept(corners: list[tuple[int, int]], closed: bool) -> None:
    points = np.array(corners, float)
    nodes = fitted(points, closed=closed)
    chain = np.vstack([points, points[:1]]) if closed else points
    assert farthest(along(nodes, closed=closed), chain) <= TOLERANCE + 1e-6
    assert farthest(points, along(nodes, closed=closed)) <= TOLERANCE + 1e-6


@given(st.floats(20, 3000), st.floats(-3, 3), st.floats(0.2, 5.5), st.booleans())
def test_an_arc_is_few_arcs(radius: float, begin: float, turn: float, left: bool) -> None:
    count = max(3, math.ceil(turn / (2 * math.acos(1 - FINE / radius)))) + 1
    angles = begin + np.linspace(0, turn if left else -turn, count)
    points = radius * np.column_stack([np.cos(angles), np.sin(angles)])
    nodes = fitted(points, closed=False)
    assert len(nodes) <= 2 + math.ceil(turn / math.radians(165))
    assert np.abs(np.hypot(*along(nodes, closed=False).T) - radius).max() <= 2 * TOLERANCE
    if radius * (1 - math.cos(turn / 4)) > 5:
        assert (nodes[0][2] > 0) == left
        assert all(bend >= 0 if left else bend <= 0 for *_, bend in nodes[1:-1])


def test_a_circle_and_a_rounded_rectangle_are_closed_in_few_pieces() -> None:
    angles = np.linspace(0, 2 * math.pi, 200, endpoint=False)
    ring = 300 * np.column_stack([np.cos(angles), np.sin(angles)])
    nodes = fitted(ring, closed=True)
    assert len(nodes) <= 3
    assert sum(math.degrees(4 * math.atan(bend)) for *_, bend in nodes) == pytest.approx(360, abs=1)
    quarter = np.linspace(0, math.pi / 2, 30)
    places = ((200, 100), (-200, 100), (-200, -100), (200, -100))
    rounded = np.vstack([
        (x, y) + 60 * np.column_stack([np.cos(quarter + turn), np.sin(quarter + turn)])
        for (x, y), turn in zip(places, np.arange(4) * math.pi / 2, strict=True)
    ])  # fmt: skip
    assert len(fitted(rounded, closed=True)) == 8


def test_points_that_fall_together_are_one() -> None:
    assert fitted(np.array([[1.0, 2.0], [1.0, 2.0]]), closed=True) == [(1.0, 2.0, 0.0)]
    assert len(fitted(np.array([[0.0, 0], [9, 0], [9, 0], [9, 9], [0, 0]]), closed=True)) == 3
