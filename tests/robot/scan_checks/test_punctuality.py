"""Pictures that come later all at once, or late by turns, are known for it; slip is not."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np
import pytest
from floor_scans import AHEAD, LEFT, PERIOD, RIGHT, drive

from robot.geometry import Pose2, Twist2, interpolate
from robot.scan import Scan
from robot.scan_checks.punctuality import CHANGE, Habit, Punctuality

BENDS = [*[LEFT] * 40, *[AHEAD] * 20, *[RIGHT] * 40]
CIRCLE = [LEFT] * 100
STANDS = Twist2()


def heard(twists: list, late: Callable[[float], float]) -> list[tuple[float, Habit]]:
    """Return what is found, and when, of pictures that are stamped later by this [s]."""
    punctuality, said, last = Punctuality(), [], -np.inf
    poses = [pose for _, pose in drive(twists)]
    for scan, _ in drive(twists):
        stamp = scan.stamp + late(scan.stamp)
        place = min(stamp / PERIOD, len(poses) - 1.001)
        odometry = interpolate(poses[int(place)], poses[int(place) + 1], place % 1)
        if stamp <= last:
            continue  # it comes out of order
        last = stamp
        before = punctuality.changed
        punctuality.add(Scan(stamp, scan.bearings, scan.ranges, scan.robot_from_scan), odometry)
        if punctuality.changed != before:
            said.append((stamp, punctuality.habit))
    return said


@pytest.mark.parametrize("begins", [0.3, 5.6, 5.9])
@pytest.mark.parametrize("late", [CHANGE + 0.02, 0.09, 0.15])
def test_pictures_that_come_later_all_at_once_are_known_within_half_a_second(
    begins: float, late: float
) -> None:
    """Tape is in sight at these times."""
    said = heard(CIRCLE, lambda stamp: late if stamp > begins else 0.0)
    assert [habit for _, habit in said] == [Habit.LATER]
    assert begins < said[0][0] < begins + 0.5 + late


@pytest.mark.parametrize("late", [0.05, 0.09, 0.15])
def test_the_first_of_them_raises_doubt_before_anything_is_said(late: float) -> None:
    punctuality, doubted = Punctuality(), []
    poses = [pose for _, pose in drive(CIRCLE)]
    for scan, _ in drive(CIRCLE):
        behind = round(late / PERIOD) if scan.stamp > 5.6 else 0
        then = poses[min(round(scan.stamp / PERIOD) + behind, len(poses) - 1)]
        stamp = scan.stamp + behind * PERIOD
        punctuality.add(Scan(stamp, scan.bearings, scan.ranges, scan.robot_from_scan), then)
        if punctuality.doubted:
            doubted.append(stamp)
    assert 5.6 < doubted[0] < 5.6 + late + 0.25


def test_how_late_they_usually_are_is_known_and_when_they_are_punctual_again() -> None:
    punctuality, usual, last = Punctuality(), {}, -np.inf
    poses = [pose for _, pose in drive(CIRCLE)]
    for scan, _ in drive(CIRCLE):
        stamp = scan.stamp + (0.09 if 0.3 < scan.stamp < 5.7 else 0.0)
        if stamp <= last:
            continue  # it comes out of order
        last = stamp
        place = min(stamp / PERIOD, len(poses) - 1.001)
        odometry = interpolate(poses[int(place)], poses[int(place) + 1], place % 1)
        punctuality.add(Scan(stamp, scan.bearings, scan.ranges, scan.robot_from_scan), odometry)
        usual[scan.stamp] = punctuality.usual
    assert np.median([late for stamp, late in usual.items() if 1 < stamp < 5.5]) == pytest.approx(
        0.09, abs=0.02
    )
    assert usual[scan.stamp] == pytest.approx(0.0, abs=0.03)


@pytest.mark.parametrize(
    ("first", "apart", "lost"), [(5.4, 0.4, 0.03), (6.6, 0.4, 0.035), (5.4, 0.6, 0.04)]
)
def test_jolts_to_one_side_are_no_pictures_that_come_by_turns(
    first: float, apart: float, lost: float
) -> None:
    """A robot that nobody had calibrated was said to see late, as its wheels slipped thrice."""
    punctuality, odometry = Punctuality(), Pose2()
    for (scan, pose), (_, after) in pairwise(drive([LEFT] * 180)):
        punctuality.add(scan, odometry)
        jolts = np.abs(scan.stamp - first - apart * np.arange(3)).min() < 0.4 * PERIOD
        odometry = odometry @ pose.inverse() @ after @ LEFT.integrate(-lost if jolts else 0.0)
    assert punctuality.habit is not Habit.BY_TURNS


@pytest.mark.parametrize(
    ("after", "habits"), [(LEFT, {Habit.PUNCTUAL, Habit.LATER}), (STANDS, {Habit.BY_TURNS})]
)
def test_pictures_that_came_by_turns_are_punctual_once_the_robot_has_driven_so_for_a_while(
    after: Twist2, habits: set[Habit]
) -> None:
    """While it stands, nobody can tell."""
    rng, twists = np.random.default_rng(3), [*[LEFT] * 120, *[after] * 240]
    said, habit = Punctuality(), []
    poses = [pose for _, pose in drive(twists)]
    for number, (scan, _) in enumerate(drive(twists)):
        stamp = scan.stamp + (rng.choice([0.0, 0.06]) if scan.stamp < 8 else 0.0)
        place = min(stamp / PERIOD, len(poses) - 1.001)
        odometry = interpolate(poses[int(place)], poses[int(place) + 1], place % 1)
        said.add(Scan(stamp, scan.bearings, scan.ranges, scan.robot_from_scan), odometry)
        habit.append((number * PERIOD, said.habit))
    assert Habit.BY_TURNS in [each for stamp, each in habit if stamp < 8]
    assert habit[-1][1] in habits


def test_pictures_that_come_late_by_turns_are_known_for_it() -> None:
    rng = np.random.default_rng(3)
    said = heard(CIRCLE, lambda _: float(rng.choice([0.0, 0.06])))
    assert Habit.BY_TURNS in [habit for stamp, habit in said if stamp < 4.0]


@pytest.mark.parametrize("late", [0.0, 0.05, 0.15])
def test_at_a_steady_speed_nobody_can_tell_that_all_pictures_are_late(late: float) -> None:
    assert not heard(CIRCLE, lambda _: late)


def test_punctual_pictures_are_punctual_however_the_robot_turns() -> None:
    assert not heard([*BENDS, *BENDS[::-1]], lambda _: 0.0)


@pytest.mark.parametrize("share", [0.7, 0.85, 1.15])
def test_wheels_that_slip_for_a_second_are_no_late_pictures(share: float) -> None:
    punctuality, odometry = Punctuality(), Pose2()
    for (scan, pose), (_, after) in pairwise(drive(CIRCLE)):
        punctuality.add(scan, odometry)
        step = pose.inverse() @ after
        slips = share if 2.0 < scan.stamp < 3.0 else 1.0
        odometry = odometry @ Pose2(step.x / slips, step.y / slips, step.theta / slips)
    assert punctuality.habit is Habit.PUNCTUAL


def test_a_robot_that_stands_or_sees_nothing_tells_nothing() -> None:
    punctuality = Punctuality()
    for number in range(60):
        bearings = np.linspace(-0.5, 0.5, 31)
        ranges = np.full(31, np.inf if number % 2 else 0.4)
        punctuality.add(Scan(number * PERIOD, bearings, ranges), Pose2())
    assert punctuality.habit is Habit.PUNCTUAL
