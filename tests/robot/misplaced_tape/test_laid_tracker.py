"""A robot is followed by tape that lies beside its drawing, and the tape is learnt."""

from __future__ import annotations

import numpy as np
import pytest
from misplaced_pieces import laid_by_hand, laps, slip_surprises

from app.settings.config import MAPS
from robot import ray_columns as column
from robot.fields.field_loading import load_field
from robot.geometry import Pose2
from robot.localization.monitoring.mounting_check import LASER, CameraPosition
from robot.misplaced_tape.laid_tape import LaidTape
from robot.misplaced_tape.laid_tracker import CAMERA, OFFSETS, LaidTracker
from robot.misplaced_tape.odometry_errors import POSE
from robot.scan import rays_of

FIELD = load_field("stub", MAPS)
TAPE = LaidTape(FIELD.edges)
START = Pose2(0.0, -0.2)
KNOWN = np.diag([2.5e-5, 2.5e-5, 1e-4])
CAMERA_SEES = CameraPosition(0.06, 0.16)


def followed(floor, seconds=20.0, tracker=None):
    """The tracker after a drive, and how far it was off at each scan [m]."""
    tracker = tracker or LaidTracker(TAPE, LASER, START, KNOWN)
    last, errors = Pose2(), []
    for scan, odometry, truth in laps(floor, seconds, reach=0.9):
        tracker.step(last.inverse() @ odometry, rays_of(scan, 61))
        last = odometry
        errors.append(tracker.pose.distance_to(truth))
    return tracker, np.array(errors)


@pytest.mark.parametrize("seed", range(4))
def test_slopes_are_those_of_the_expected_ranges(seed):
    rng = np.random.default_rng(seed)
    tracker = LaidTracker(TAPE, CAMERA_SEES, Pose2(0.05, -0.1, rng.uniform(-3, 3)), KNOWN)
    tracker.camera = rng.normal(0, 0.0005, 3)  # what it changes of other slopes is left out
    tracker.offsets = rng.normal(0, 0.004, len(TAPE.prior))
    tracker._lay()
    scan, _, _ = next(laps(FIELD, 1.0, tracker.pose, reach=0.9))
    rays = rays_of(scan, 61)
    looks = tracker._looks(rays)
    assert len(looks.errors) > 20
    step = 1e-5
    for number in range(looks.slopes.shape[1]):
        change = np.zeros(looks.slopes.shape[1])
        change[number] = step
        other = LaidTracker(TAPE, CAMERA_SEES, _beside(tracker.pose, change[POSE]), KNOWN)
        other.camera = tracker.camera + change[CAMERA]
        other.offsets = tracker.offsets + change[OFFSETS]
        other._lay()
        slope = (looks.errors - other._looks(rays).errors) / step
        # A ray at a joint of two parts may pass on to the other part.
        assert np.mean(np.abs(slope - looks.slopes[:, number]) < 0.03) > 0.9, number


def _beside(pose, change):
    return Pose2(pose.x + change[0], pose.y + change[1], pose.theta + change[2])


def test_a_robot_on_tape_as_drawn_stays_right():
    tracker, errors = followed(FIELD)
    assert errors[30:].max() < 0.006
    assert tracker.is_plausible


@pytest.mark.parametrize("seed", range(3))
def test_tape_that_lies_aside_is_learnt(seed):
    floor = laid_by_hand(FIELD, seed)
    tracker, errors = followed(floor)
    rigid = LaidTracker(LaidTape(FIELD.edges, scales=False, bends=False), LASER, START, KNOWN)
    _, without = followed(floor, tracker=rigid)
    assert np.sqrt((errors**2).mean()) < 0.6 * np.sqrt((without**2).mean())
    assert errors.max() < 0.015
    assert tracker.is_plausible


def test_its_standard_deviation_tells_how_far_it_is_off():
    """Normalized squared errors of the place, over floors: 2 on the average if it does."""
    ratios = []
    for seed in range(6):
        tracker, errors = followed(laid_by_hand(FIELD, 40 + seed), 12.0)
        ratios.append(errors[-1] ** 2 / np.trace(tracker.covariance[:2, :2]) * 2)
    assert 0.2 < np.mean(ratios) < 3


def test_wheels_that_slip_while_nothing_is_seen_are_expected():
    """A robot of *town* that saw no tape for 1.3 s turned by 5 degrees more than its wheels said,
    as they do that slip by 2 %; then its tape was said to lie aside, and it stood 4 cm off."""
    squared = slip_surprises(lambda: LaidTracker(TAPE, CAMERA_SEES, START, KNOWN))
    assert 0.3 < np.mean(squared) < 2


def test_a_floor_that_is_larger_is_told():
    tracker, _ = followed(laid_by_hand(FIELD, 1, sd=0.0, scale=1.03))
    assert tracker.offsets[-1] == pytest.approx(0.03, abs=0.015)


def test_steps_of_a_robot_that_was_moved_contradict_odometry():
    tracker, _ = followed(FIELD, 6.0)
    last, leaps = None, []
    for scan, odometry, _ in laps(FIELD, 3.0, tracker.pose @ Pose2(0.02, 0.02)):
        moved = Pose2() if last is None else last.inverse() @ odometry
        tracker.step(moved, rays_of(scan, 61))
        last = odometry
        leaps.append(tracker.leap)
    assert leaps[0] > 8
    assert max(leaps[10:]) < 3


def test_what_was_learnt_of_the_tape_stays_when_the_robot_is_elsewhere():
    tracker, _ = followed(laid_by_hand(FIELD, 2))
    offsets, covariance = tracker.offsets.copy(), tracker.offsets_covariance
    tracker.restart(Pose2(0.1, 0.1), KNOWN)
    assert np.array_equal(tracker.offsets, offsets)
    assert np.array_equal(tracker.offsets_covariance, covariance)
    assert np.array_equal(tracker.covariance, KNOWN)


def test_rays_that_must_see_tape_and_return_nothing_are_misses():
    tracker = LaidTracker(TAPE, LASER, START, KNOWN)
    scan, _, _ = next(laps(FIELD, 1.0))
    rays = rays_of(scan, 61).copy()
    tracker.step(Pose2(), rays)
    assert (tracker.misses, tracker.fits > 10) == (0, True)
    rays[:, column.RANGE] = np.inf
    tracker.step(Pose2(), rays)
    assert (tracker.fits, tracker.misses > 5) == (0, True)
