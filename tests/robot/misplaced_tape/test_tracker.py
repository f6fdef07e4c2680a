"""A place is followed by odometry and scans, and it is known how far it may be off."""

from __future__ import annotations

import numpy as np
import pytest
from misplaced_pieces import NOTHING, laps, slip_surprises

from app.settings.config import MAPS
from robot.fields.field_loading import load_field
from robot.geometry import Pose2
from robot.misplaced_tape.tracker import BESIDE_SDS, FARTHEST_BESIDE, PlaceTracker
from robot.scan import rays_of

FIELD = load_field("stub", MAPS)
START = Pose2(0.0, -0.2)
KNOWN = np.diag([2.5e-5, 2.5e-5, 1e-4])


def test_scans_keep_the_place():
    tracker, last = PlaceTracker(FIELD.edges, START @ Pose2(0.005, -0.005), KNOWN), Pose2()
    for scan, odometry, truth in laps(FIELD, 6.0):  # noqa: B007 - the last one is meant
        tracker.step(last.inverse() @ odometry, rays_of(scan, 61))
        last = odometry
    assert tracker.pose.distance_to(truth) < 0.005
    assert tracker.leap < 4.5
    assert tracker.width < 0.005
    assert np.allclose(tracker.covariance, tracker.covariance.T, rtol=1e-6)


def test_what_scans_tell_of_the_wheels_stays_when_nothing_is_seen():
    """Wheels that report 2 % too little of each turn, and 1 % too much of each way."""
    tracker, last = PlaceTracker(FIELD.edges, START, KNOWN), Pose2()
    drive = list(laps(FIELD, 8.0))
    for scan, odometry, _ in drive[:-20]:
        tracker.step(last.inverse() @ odometry, rays_of(scan, 61))
        last = odometry
    alone = tracker.pose @ (last.inverse() @ drive[-1][1])
    for _, odometry, _ in drive[-20:]:
        tracker.step(last.inverse() @ odometry, NOTHING)
        last = odometry
    truth = drive[-1][2]
    assert abs(tracker.pose.turn_to(truth)) < 0.8 * abs(alone.turn_to(truth))


def test_wheels_that_slip_while_nothing_is_seen_are_expected():
    """It claimed 2 mrad where slip makes 60; the first tape then seemed to show that it was
    moved, and what had explained its doubt was dropped for good."""
    squared = slip_surprises(lambda: PlaceTracker(FIELD.edges, START, KNOWN))
    assert 0.3 < np.mean(squared) < 2


@pytest.mark.parametrize("axis", range(3))
@pytest.mark.parametrize("sd", [0.02, 0.5])
def test_other_places_lie_on_both_sides_of_one_that_is_not_known(axis, sd):
    covariance = np.diag([1e-6, 1e-6, 1e-6])
    covariance[axis, axis] = sd**2
    tracker = PlaceTracker(FIELD.edges, START, covariance)
    sides = [each.to_array() - START.to_array() for each in tracker.others]
    assert sides[0] == pytest.approx(-sides[1])
    lever = 1.0 if axis < 2 else 0.25
    assert abs(sides[0][axis]) == pytest.approx(
        min(BESIDE_SDS * sd, FARTHEST_BESIDE / lever), rel=1e-6
    )
    assert abs(np.delete(sides[0], axis)).max() < 1e-9


def test_a_place_that_is_known_has_none_beside():
    assert PlaceTracker(FIELD.edges, START, np.diag([1e-6, 1e-6, 1e-6])).others == ()
