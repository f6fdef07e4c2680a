"""Where the outline of tape ends: at its corners, and not at the joints of a curve."""

from __future__ import annotations

import math

import numpy as np
import pytest
import shapely
from stub_drive import MAPS, STUB

from robot.fields.edges import outline, sharp_ends
from robot.fields.field import Field
from robot.fields.field_loading import load_field

SQUARE, TOWN = load_field("square", MAPS), load_field("town", MAPS)


@pytest.mark.parametrize("of", [SQUARE, STUB], ids=["square", "stub"])
def test_edges_of_straight_tape_end_at_its_corners(of: Field) -> None:
    ends = sharp_ends(of.edges)
    assert ends.shape == (len(of.edges), 2) and ends.all()


def test_the_joints_of_a_curve_are_no_ends() -> None:
    assert not sharp_ends(outline(shapely.Point(0, 0).buffer(0.3, quad_segs=16))).any()
    # Half a disc: a curve with two corners.
    half = shapely.intersection(
        shapely.Point(0, 0).buffer(0.3, quad_segs=16), shapely.box(-1, 0, 1, 1)
    )
    edges = outline(half)
    ends = sharp_ends(edges)
    assert ends[:, 0].sum() == ends[:, 1].sum() == 2
    corners = np.vstack([edges[ends[:, 0], :2], edges[ends[:, 1], 2:]])
    np.testing.assert_allclose(np.abs(corners), np.tile([0.3, 0], (4, 1)), atol=1e-9)


def test_in_a_town_the_bends_are_no_ends() -> None:
    ends = sharp_ends(TOWN.edges)
    assert 8 <= ends[:, 1].sum() < 0.5 * len(ends)
    assert ends[:, 0].sum() == ends[:, 1].sum(), "each joint is of one edge's end and one's start"


@pytest.mark.parametrize(
    ("turn", "sharp"), [(0.2, False), (-0.2, False), (0.4, True), (-0.4, True)]
)
def test_how_much_an_outline_turns_makes_it_end(turn: float, sharp: bool) -> None:
    for heading in (0.0, math.pi - 0.1):
        a = np.array([math.cos(heading), math.sin(heading)])
        b = a + np.array([math.cos(heading + turn), math.sin(heading + turn)])
        edges = np.array([[0.0, 0.0, *a], [*a, *b]])
        np.testing.assert_array_equal(sharp_ends(edges), [[True, sharp], [sharp, True]])
