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
from robot.misplaced_tape.without_piece import WithoutPiece

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
    floor, without = moved(FIELD, DRAWING.pieces[RIGHT], shift), None
    search = MisplacedTapeSearch(DRAWING, Pose2(0.0, -0.2), KNOWN, Pose2())
    for scan, odometry, truth in laps(floor, 2 * SECONDS):
        if without is not None:
            without.clear(scan, odometry)
            continue
        what = search.add(scan, odometry)
        if what is not None:
            follower = search.without(what.piece)
            assert what.piece == RIGHT
            assert follower.tracker.pose.distance_to(truth) < 0.02
            without = WithoutPiece(DRAWING, follower, what, odometry)
    assert without.finding.piece == RIGHT
    assert without.finding.aside == pytest.approx(abs(shift[0]), abs=0.01)


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


def test_a_piece_elsewhere_is_a_rival_until_other_tape_proves_the_place():
    """A filter was certain 10 cm off meanwhile: it took the piece for where it is drawn."""
    start = Pose2(0.0, -0.2)
    search, rivals = MisplacedTapeSearch(DRAWING, start, KNOWN, Pose2()), []
    for scan, odometry, truth in laps(moved(FIELD, DRAWING.pieces[RIGHT], (0.1, 0.0)), SECONDS):
        if search.add(scan, odometry) is not None:
            break
        if search.rival is not None:
            rivals.append(search.rival.distance_to(truth))
    assert len(rivals) > 10
    assert max(rivals) < 0.03


def test_a_floor_as_drawn_has_no_rival():
    search = MisplacedTapeSearch(DRAWING, Pose2(0.0, -0.2), KNOWN, Pose2())
    for scan, odometry, _ in laps(FIELD, 6.0):
        search.add(scan, odometry)
        assert search.rival is None


@pytest.mark.parametrize(("off", "settled"), [(0.0, True), (0.2, False)])
def test_a_robot_found_where_odometry_led_has_looked_through_a_missing_piece(off, settled):
    search = MisplacedTapeSearch(DRAWING, Pose2(0.0, -0.2), KNOWN, Pose2())
    for scan, odometry, truth in laps(moved(FIELD, DRAWING.pieces[RIGHT], None), SECONDS):
        assert search.settle(truth, KNOWN) is None or search.without(RIGHT).through >= 80
        if search.add(scan, odometry) is not None or search.settle(truth, KNOWN) is not None:
            break
    what = search.settle(truth @ Pose2(off), KNOWN)
    assert (what is not None and what.piece == RIGHT) is settled


def test_nothing_is_settled_where_all_was_seen():
    search = MisplacedTapeSearch(DRAWING, Pose2(0.0, -0.2), KNOWN, Pose2())
    for scan, odometry, truth in laps(FIELD, 6.0):  # noqa: B007 - the last one is meant
        search.add(scan, odometry)
    assert search.settle(truth, KNOWN) is None
