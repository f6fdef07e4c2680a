"""Motors that are plugged in wrongly are named; those plugged in rightly never."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from floor_scans import AHEAD, CENTRE, LEFT, PERIOD, RIGHT, SPIN, drive

from robot.geometry import Pose2, Twist2
from robot.scan import Scan
from robot.scan_checks.plug_check import LONGEST, PlugCheck, Plugs

TRACK = 0.12
BENDS = [*[LEFT] * 40, *[AHEAD] * 20, *[RIGHT] * 40]
WAYS = {"bends": BENDS, "on the spot": [SPIN] * 100, "ahead": [AHEAD] * 60}


def told(step: Pose2, plugs: Plugs, scale: tuple[float, float] = (1.0, 1.0)) -> Pose2:
    """Return a step as wheels tell it that are plugged in so, and are not as large as drawn."""
    way, half = math.copysign(math.hypot(step.x, step.y), step.x), step.theta * TRACK / 2
    truly = np.array([way - half, way + half])
    left, right = np.linalg.inv(np.array(plugs.value)) @ truly * scale
    return Twist2((left + right) / 2, (right - left) / TRACK).integrate(1.0)


def checked(twists: list[Twist2], plugs: Plugs, scale: tuple[float, float] = (1.0, 1.0)) -> Plugs:
    """Return what is found on a drive; it must not change once it is known."""
    check, odometry, found = PlugCheck(TRACK), Pose2(), Plugs.RIGHT
    for (scan, pose), (_, after) in pairwise(drive(twists)):
        check.add(scan, odometry)
        odometry = odometry @ told(pose.inverse() @ after, plugs, scale)
        assert found in (Plugs.RIGHT, check.plugs)
        found = check.plugs
    return found


@pytest.mark.parametrize("plugs", Plugs, ids=lambda plugs: plugs.name.lower())
@pytest.mark.parametrize("way", ["bends", "on the spot"])
def test_motors_that_are_plugged_in_wrongly_are_named(plugs: Plugs, way: str) -> None:
    assert checked(WAYS[way], plugs) in _same_on(way, plugs)


def _same_on(way: str, plugs: Plugs) -> tuple[Plugs, ...]:
    """Return what cannot be told from these plugs: on the spot, both wheels turn as much."""
    if way == "bends":
        return (plugs,)
    same = ((Plugs.RIGHT, Plugs.TURNED_ROUND), (Plugs.SWAPPED, Plugs.BOTH_REVERSED))
    return next((pair for pair in same if plugs in pair), (plugs,))


def test_straight_ahead_nobody_can_tell_swapped_motors_and_none_are_named() -> None:
    assert checked(WAYS["ahead"], Plugs.SWAPPED) is Plugs.RIGHT


@pytest.mark.parametrize("scale", [(1.1, 1.1), (0.9, 0.95), (1.05, 0.95), (1.3, 1.3)])
@pytest.mark.parametrize("way", WAYS)
def test_wheels_of_another_size_are_plugged_in_rightly(
    way: str, scale: tuple[float, float]
) -> None:
    assert checked(WAYS[way], Plugs.RIGHT, scale) is Plugs.RIGHT


def test_a_mirrored_picture_moves_as_with_swapped_motors() -> None:
    check = PlugCheck(TRACK)
    for scan, pose in drive(BENDS, mirrored=True):
        check.add(scan, pose)
    assert check.plugs is Plugs.SWAPPED


def test_while_wheels_turn_and_the_robot_stands_nothing_is_named() -> None:
    for twists in (BENDS, [SPIN] * 100):
        check, odometry = PlugCheck(TRACK), Pose2()
        for (scan, _), twist in zip(drive([Twist2()] * len(twists)), twists, strict=True):
            check.add(scan, odometry)
            odometry = odometry @ twist.integrate(PERIOD)
            assert check.plugs is Plugs.RIGHT


def test_once_motors_are_plugged_in_rightly_that_is_drive() -> None:
    check, odometry = PlugCheck(TRACK), Pose2()
    found = []
    for number, ((scan, pose), (_, after)) in enumerate(pairwise(drive([LEFT] * 300))):
        check.add(scan, odometry)
        plugs = Plugs.SWAPPED if number < 150 else Plugs.RIGHT
        odometry = odometry @ told(pose.inverse() @ after, plugs)
        found.append(check.plugs)
    assert found[149] is Plugs.SWAPPED and found[-1] is Plugs.RIGHT


@pytest.mark.parametrize("elapsed", [0.0, -1.0, 2 * LONGEST])
def test_after_a_jump_in_time_comparing_begins_anew(elapsed: float) -> None:
    check = PlugCheck(TRACK)
    for number, (scan, pose) in enumerate(drive(BENDS, mirrored=True)):
        check.add(Scan(number * elapsed, scan.bearings, scan.ranges, CENTRE), pose)
    assert check.plugs is Plugs.RIGHT


@pytest.mark.parametrize("rays", [0, 1, 2, 12])
def test_scans_of_few_rays_tell_nothing(rays: int) -> None:
    check = PlugCheck(TRACK)
    for number in range(30):
        scan = Scan(number * PERIOD, np.linspace(-0.5, 0.5, rays), np.full(rays, 0.4))
        check.add(scan, Pose2(theta=0.1 * number))
    assert check.plugs is Plugs.RIGHT
