"""The filter of lateness tells how late each picture is from what differs between two of them."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from floor_scans import AHEAD, LEFT, PERIOD, RIGHT, drive

from robot.geometry import Pose2, interpolate
from robot.scan_checks.lateness_filter import MEAN, MEAN_SD, SWAYS, LatenessFilter
from robot.scan_checks.overlay import near_points
from robot.scan_checks.timed_tape import RecentPath, TimedTape

BENDS = [*[LEFT] * 60, *[AHEAD] * 20, *[RIGHT] * 40]

TOLD = 0.025
"""Of a picture with tape in common with others it is known to this [s]."""


def tapes(late: np.ndarray) -> Iterator[TimedTape]:
    """Yield the tape of a drive, whose pictures are stamped later by these times [s]."""
    poses, path = [pose for _, pose in drive(BENDS)], RecentPath()
    for number, (scan, _) in enumerate(drive(BENDS)):
        place = min(number + late[number] / PERIOD, len(poses) - 1.001)
        odometry = interpolate(poses[int(place)], poses[int(place) + 1], place % 1)
        yield TimedTape(
            path.add(scan.stamp + late[number], odometry), BENDS[number], near_points(scan)
        )


def test_where_there_is_tape_most_of_lateness_is_known() -> None:
    errors, claimed, true = [], [], []
    for seed in range(10):
        late = np.random.default_rng(seed).uniform(0.0, 0.06, len(BENDS))
        known = LatenessFilter()
        for tape, by in zip(tapes(late), late, strict=True):
            known.add(tape)
            errors.append(known.late - by)
            claimed.append(known.sd)
            true.append(by)
    told = np.array(claimed) < TOLD
    assert told.mean() > 0.3
    assert np.std(np.array(errors)[told]) < 0.5 * np.std(true)
    mean = np.mean(np.array(errors)[told])
    assert mean == pytest.approx(MEAN - 0.03, abs=0.005)  # 0.03 is what nobody can know
    by_tape = np.sqrt(np.square(claimed) - MEAN_SD**2)
    assert 0.9 < np.mean(np.abs(errors - mean) < 2 * by_tape) < 1.0


def test_without_tape_nothing_is_known_but_how_late_pictures_are_that_come_by_turns() -> None:
    known, path = LatenessFilter(), RecentPath()
    for number in range(5):
        odometry = Pose2(0.01 * number)
        known.add(TimedTape(path.add(number * PERIOD, odometry), AHEAD, np.empty((0, 2))))
    assert known.late == pytest.approx(MEAN)
    assert known.sd == pytest.approx(np.hypot(SWAYS, MEAN_SD), rel=0.01)


def test_tape_was_taken_where_the_robot_was_then() -> None:
    path = RecentPath()
    for number in range(5):
        before = path.add(number * PERIOD, Pose2(0.01 * number))
    turned = TimedTape(path.add(5 * PERIOD, Pose2(0.04, 0.0, 0.3)), LEFT, np.empty((0, 2)))
    assert len(before) == 5
    assert turned.taken_at(0.0) == Pose2(0.04, 0.0, 0.3)
    assert turned.taken_at(0.5 * PERIOD).theta == pytest.approx(0.15)
    assert turned.taken_at(2.5 * PERIOD).x == pytest.approx(0.025)
    # Later than its stamp it drives on as it did.
    later = turned.odometry.inverse() @ turned.taken_at(-0.1)
    np.testing.assert_allclose(later.to_array(), LEFT.integrate(0.1).to_array(), atol=1e-12)
