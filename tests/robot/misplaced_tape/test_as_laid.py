"""Scans of tape that lies beside its drawing become those that the drawing would give."""

from __future__ import annotations

import pickle

import numpy as np
import pytest
from floor_scans import BEARINGS, CENTRE
from misplaced_pieces import laid_by_hand, laps

from app.settings.config import MAPS
from robot.fields.field_loading import load_field
from robot.geometry import Pose2
from robot.localization.monitoring.mounting_check import LASER
from robot.misplaced_tape.as_laid import AsLaid
from robot.misplaced_tape.laid_tape import LaidTape
from robot.misplaced_tape.laid_tracker import LaidTracker

FIELD = load_field("stub", MAPS)
TAPE = LaidTape(FIELD.edges)
START = Pose2(0.0, -0.2)
KNOWN = np.diag([1e-6, 1e-6, 1e-6])


def followed(floor, seconds):
    """The remedy after a drive, and the corrected scans with the truth."""
    laid = AsLaid(LaidTracker(TAPE, LASER, START, KNOWN), Pose2())
    seen = [
        (laid.clear(scan, odometry), scan, truth)
        for scan, odometry, truth in laps(floor, seconds, reach=0.9)
    ]
    return laid, seen


@pytest.mark.parametrize("seed", range(3))
def test_corrected_scans_are_those_of_the_drawing(seed):
    """From where the robot is said to be, which is right to some millimetres."""
    laid, seen = followed(laid_by_hand(FIELD, seed), 12.0)
    before, after = [], []
    for corrected, scan, truth in seen[60:]:
        drawn = FIELD.ranges((truth @ CENTRE).to_array()[None], BEARINGS, 0.9)[0]
        both = np.isfinite(drawn) & np.isfinite(corrected.ranges) & np.isfinite(scan.ranges)
        before.append(np.median(np.abs(scan.ranges - drawn)[both]))
        after.append(np.median(np.abs(corrected.ranges - drawn)[both]))
    assert np.mean(after) < 0.6 * np.mean(before)
    assert not laid.is_lost


def test_scans_of_tape_as_drawn_stay_as_they_are():
    _, seen = followed(FIELD, 8.0)
    for corrected, scan, _ in seen:
        both = np.isfinite(corrected.ranges) & np.isfinite(scan.ranges)
        assert both.sum() >= 0.9 * np.isfinite(scan.ranges).sum()
        assert np.abs(corrected.ranges - scan.ranges)[both].max() < 0.012


def test_a_robot_that_was_carried_off_is_lost_and_goes_on_where_it_is_found():
    laid, _ = followed(laid_by_hand(FIELD, 1), 8.0)
    learnt = laid.finding
    away = Pose2(0.15, 0.2, 2.0)
    for scan, odometry, _ in laps(FIELD, 4.0, away):
        laid.clear(scan, odometry)
        if laid.is_lost:
            break
    assert laid.is_lost
    laid.restart(away, KNOWN, Pose2())
    assert not laid.is_lost
    assert laid.place(Pose2())[0] == away
    assert laid.finding.aside == pytest.approx(learnt.aside, abs=0.02)


def test_the_place_follows_odometry_between_scans():
    laid, _ = followed(FIELD, 2.0)
    here, covariance = laid.place(laid._odometry)
    ahead, _ = laid.place(laid._odometry @ Pose2(0.1))
    assert here.distance_to(ahead) == pytest.approx(0.1)
    assert np.all(np.linalg.eigvalsh(covariance) > 0)


def test_it_is_kept_with_the_state_of_a_run():
    laid, _ = followed(laid_by_hand(FIELD, 1), 4.0)
    again = pickle.loads(pickle.dumps(laid))
    assert again.finding == laid.finding
