"""Tape that was laid by hand, or larger, is told from a robot that is elsewhere, or slips."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from misplaced_pieces import laid_by_hand, laps, moved

from app.settings.config import MAPS
from robot.fields.field_loading import load_field
from robot.geometry import Pose2
from robot.localization.monitoring.mounting_check import LASER
from robot.misplaced_tape.laid_search import LONGEST, LaidSearch, LaidTapes
from robot.misplaced_tape.pieces import pieces_of

FIELD = load_field("stub", MAPS)
TAPES = LaidTapes(FIELD.edges)
START = Pose2(0.0, -0.2)
KNOWN = np.diag([2.5e-5, 2.5e-5, 1e-4])
SECONDS = 20.0


def searched(floor, *, off=Pose2(), seconds=SECONDS, **drive):
    """Who follows the robot on tape as it lies, how far that one is off [m], and the search."""
    search = LaidSearch(TAPES, LASER, START @ off, KNOWN, Pose2())
    for scan, odometry, truth in laps(floor, seconds, START, **drive):
        tracker = search.add(scan, odometry)
        if tracker is not None:
            return tracker, tracker.pose.distance_to(truth), search
    return None, None, search


@pytest.mark.parametrize("seed", range(4))
def test_tape_laid_by_hand_is_told(seed):
    tracker, error, _ = searched(laid_by_hand(FIELD, seed))
    assert tracker is not None
    assert error < 0.015


@pytest.mark.parametrize("scale", [1.03, 0.97])
def test_a_floor_of_another_size_is_told(scale):
    tracker, error, _ = searched(laid_by_hand(FIELD, 1, sd=0.0, scale=scale))
    assert tracker.offsets[-1] == pytest.approx(scale - 1, abs=0.015)
    assert error < 0.015


@pytest.mark.parametrize("wheels", [(1.0, 1.0), (1.02, 0.97), (0.97, 1.03)])
def test_nothing_is_told_of_tape_as_drawn(wheels):
    assert searched(FIELD, wheels=wheels)[0] is None


def test_tape_as_drawn_is_soon_believed():
    """Each healthy robot that was in doubt for a moment was searched for 20 s, at a third of all
    that it costs."""
    for seconds, done in ((0.5, False), (5.0, True)):
        assert searched(FIELD, seconds=seconds)[2].failed is done


@pytest.mark.parametrize(
    "off", [Pose2(0.1, 0.0), Pose2(-0.1, -0.1, 0.3), Pose2(0.0, 0.0, np.pi / 2)]
)
def test_a_robot_that_is_elsewhere_blames_no_tape(off):
    assert searched(FIELD, off=off)[0] is None


@pytest.mark.parametrize("shift", [None, (0.1, 0.0)])
def test_one_piece_that_is_missing_or_far_aside_is_not_all_tape(shift):
    pieces = pieces_of(FIELD.edges)
    right = max(pieces, key=lambda piece: piece.middle[0])
    assert searched(moved(FIELD, right, shift))[0] is None


def test_a_robot_that_is_moved_blames_no_tape():
    for aside in (Pose2(0.03, 0.02), Pose2(0.0, 0.0, 0.2), Pose2(0.5, 0.3, 0.2)):
        search = LaidSearch(TAPES, LASER, START, KNOWN, Pose2())
        last = Pose2()
        for start in (START, START @ aside):
            for scan, odometry, _ in laps(FIELD, 3.0, start):
                assert search.add(scan, last @ odometry) is None
            last = last @ odometry


def test_it_ends_when_nothing_is_found_for_long():
    search = searched(FIELD, seconds=0.5)[2]
    assert not search.failed
    scan, odometry, _ = next(laps(FIELD, 1.0))
    step = Pose2(0.002)
    for _ in range(LONGEST + 1):
        odometry = odometry @ step
        search.add(replace(scan, ranges=np.full_like(scan.ranges, np.inf)), odometry)
    assert search.failed
