"""The edges of a drawing are grouped to pieces of tape."""

from __future__ import annotations

import numpy as np
import pytest

from app.settings.config import MAPS
from robot.fields.field_loading import load_field
from robot.misplaced_tape.pieces import pieces_of


@pytest.mark.parametrize(("name", "sides"), [("square", 4), ("stub", 5), ("tee", 6)])
def test_each_side_of_a_field_is_a_piece(name, sides):
    field = load_field(name, MAPS)
    pieces = pieces_of(field.edges)
    assert sum(piece.length > 0.1 for piece in pieces) == sides


@pytest.mark.parametrize("name", ["square", "town", "generated-3", "generated-8"])
def test_each_edge_belongs_to_one_piece(name):
    field = load_field(name, MAPS)
    owned = np.concatenate([piece.edges for piece in pieces_of(field.edges)])
    assert sorted(owned.tolist()) == list(range(len(field.edges)))


def test_both_edges_of_a_strip_and_the_chords_of_a_bend_belong_together():
    field = load_field("square", MAPS)
    right = next(piece for piece in pieces_of(field.edges) if piece.middle[0] > 0.3)
    assert len(right.edges) == 2
    assert right.middle == pytest.approx((0.5, 0.0), abs=1e-6)
    turn = np.linspace(0, 1, 20)
    ring = np.column_stack([np.cos(turn), np.sin(turn)])
    chords = np.hstack([ring[:-1], ring[1:]])
    assert len(pieces_of(chords)) == 1
