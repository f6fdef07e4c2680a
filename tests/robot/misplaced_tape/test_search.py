"""A piece of tape that does not lie where it is drawn is found, and nothing else is."""

from __future__ import annotations

import numpy as np
import pytest
from misplaced_pieces import laps, moved

from app.settings.config import MAPS
from robot.fields.field_loading import load_field
from robot.geometry import Pose2
from robot.misplaced_tape.search import MisplacedTapeSearch
from robot.misplaced_tape.tape_drawing import TapeDrawing

KNOWN = np.diag([1e-5, 1e-5, 1e-4])
SECONDS = 20.0
FIELD = load_field("stub", MAPS)
DRAWING = TapeDrawing(FIELD.edges)
RIGHT = next(n for n, piece in enumerate(DRAWING.pieces) if piece.middle[0] > 0.45)


def found(floor, start=Pose2(0.0, -0.2), off=Pose2()):
    """What is found, and how far the place is off then [m]."""
    search = MisplacedTapeSearch(DRAWING, start @ off, KNOWN, Pose2())
    for scan, odometry, truth in laps(floor, SECONDS, start):
        what = search.add(scan, odometry)
        if what is not None:
            follower = search.without(what.piece)
            return what, follower.tracker.pose.distance_to(truth)
    return None, None


@pytest.mark.parametrize("shift", [(0.1, 0.0), (-0.08, 0.0), (0.15, 0.0)])
def test_a_piece_elsewhere_is_named_and_measured(shift):
    what, error = found(moved(FIELD, DRAWING.pieces[RIGHT], shift))
    assert what.piece == RIGHT
    assert what.aside == pytest.approx(abs(shift[0]), abs=0.015)
    assert error < 0.02


@pytest.mark.parametrize(
    "piece", [n for n, piece in enumerate(DRAWING.pieces) if piece.length > 0.5]
)
def test_a_missing_piece_is_named(piece):
    what, error = found(moved(FIELD, DRAWING.pieces[piece], None))
    assert (what.piece, what.aside) == (piece, None)
    assert error < 0.02


def test_nothing_is_said_of_a_floor_as_drawn():
    assert found(FIELD) == (None, None)


@pytest.mark.parametrize(
    "off", [Pose2(0.1, 0.0), Pose2(0.0, 0.1), Pose2(-0.1, -0.1, 0.3), Pose2(0.0, 0.0, np.pi / 2)]
)
def test_a_robot_that_is_elsewhere_blames_no_tape(off):
    """It may as well have been moved: other tape has to prove its place."""
    assert found(FIELD, off=off) == (None, None)
