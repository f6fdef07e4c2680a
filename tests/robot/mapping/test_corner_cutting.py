"""Outlines are cut at their corners, whatever their angle, and nowhere else."""

import math

import numpy as np
import pytest
from mappings import WIDTH

from robot.geometry import Array
from robot.mapping.bends import at_corners, cut_at_corners
from robot.mapping.strokes import Stroke, Strokes

STEP = 0.015


def traced(outline: Array, seed: int = 1) -> Array:
    """Points along lines between points (n, 2), as they are traced: round at corners, and noisy."""
    walked = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(outline, axis=0).T))])
    fine = np.linspace(0.0, walked[-1], round(1e3 * walked[-1]))
    smooth = np.ones(25) / 25
    points = np.column_stack(
        [np.convolve(np.pad(np.interp(fine, walked, column), 12, "edge"), smooth, "valid")
         for column in outline.T]
    )  # fmt: skip
    points = points[:: round(1e3 * STEP)]
    return points + np.random.default_rng(seed).normal(0.0, 0.0002, points.shape)


def corner(turn: float, length: float = 0.4) -> Array:
    after = length * np.array([math.cos(turn), math.sin(turn)])
    return np.array([[-length, 0.0], [0.0, 0.0], after])


def arcs(radius: float, turn: float) -> Array:
    """A straight line, a bend, and a straight line."""
    turns = np.linspace(0.0, turn, 60)
    bend = radius * np.column_stack([np.sin(turns), 1 - np.cos(turns)])
    after = bend[-1] + 0.3 * np.array([math.cos(turn), math.sin(turn)])
    return np.vstack([[-0.3, 0.0], bend, after])


@pytest.mark.parametrize("degrees", [20, 30, 45, 60, 72, 90, 120])
def test_a_corner_of_any_angle_is_one(degrees: int) -> None:
    before, after = at_corners(traced(corner(math.radians(degrees))))
    for piece, along in ((before, 0.0), (after, math.radians(degrees))):
        across = np.array([-math.sin(along), math.cos(along)])
        assert np.abs(piece @ across).max() < 0.002
        assert 0.3 < math.dist(piece[0], piece[-1]) < 0.39


@pytest.mark.parametrize("degrees", [45, 90, 180])
@pytest.mark.parametrize("radius", [0.1, 0.15, 0.3, 0.6])
def test_what_bends_is_no_corner(radius: float, degrees: int) -> None:
    line = traced(arcs(radius, math.radians(degrees)))
    (piece,) = at_corners(line)
    assert piece is line


@pytest.mark.parametrize("count", [5, 6, 8])
def test_a_ring_of_sides_opens_at_its_corners(count: int) -> None:
    turns = np.arange(count + 1) * math.tau / count
    # It begins within a side, as a line does that was traced.
    points = 0.6 * np.column_stack([np.cos(turns), np.sin(turns)])
    middle = (points[:1] + points[1:2]) / 2
    line = traced(np.vstack([middle, points[1:], middle]))
    line = np.vstack([line, line[:1]])
    pieces = at_corners(line, closed=True)
    assert len(pieces) == count
    for piece in pieces:
        distance = np.hypot(*piece.T).min()
        assert distance == pytest.approx(0.6 * math.cos(math.pi / count), abs=0.002)


def test_a_circle_stays_closed() -> None:
    turns = np.linspace(0, math.tau, 120)
    ring = 0.3 * np.column_stack([np.cos(turns), np.sin(turns)])
    ring[-1] = ring[0]
    (piece,) = at_corners(ring, closed=True)
    assert piece is ring


def test_a_spline_with_all_its_nodes_shows_its_corner() -> None:
    sides = traced(corner(math.radians(45)), 2)[::2]
    bent = Stroke(arcs(0.3, 1.0)[::4], curved=True)
    strokes = Strokes.of([Stroke(sides, curved=True), bent], WIDTH)
    cut = cut_at_corners(strokes)
    assert len(cut.each) == 3
    assert [stroke.curved for stroke in cut.each] == [False, False, True]
    np.testing.assert_array_equal(cut.each[2].nodes, bent.nodes)
    assert cut_at_corners(cut) is cut


def test_a_corner_that_looks_wider_is_one_only_where_the_path_is_rough() -> None:
    """An arc of 85 mm begins 35 mm before its tip."""
    bend = traced(arcs(0.085, math.radians(45)), 3)[::2]
    strokes = Strokes.of([Stroke(bend, curved=True)], WIDTH)
    assert cut_at_corners(strokes) is strokes
    cut = cut_at_corners(strokes, rough=True)
    assert [stroke.curved for stroke in cut.each] == [False, False]
