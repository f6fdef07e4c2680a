"""Motors that are plugged in wrongly are named; those plugged in rightly never."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import pairwise

import numpy as np
import pytest

from app.features.plausibility.plug_check import LONGEST, PlugCheck, Plugs
from robot.geometry import Array, Pose2, Twist2
from robot.scan import Scan

PERIOD = 1 / 15
BEARINGS = np.radians(np.linspace(-45, 45, 91))
CENTRE = Pose2(0.05)
"""Where rays start, ahead of the robot."""
NOISE = 0.0005
TRACK = 0.12
AHEAD, LEFT, RIGHT, SPIN = Twist2(0.15), Twist2(0.15, 0.6), Twist2(0.15, -0.6), Twist2(0.0, 0.8)
BENDS = [*[LEFT] * 40, *[AHEAD] * 20, *[RIGHT] * 40]
WAYS = {"bends": BENDS, "on the spot": [SPIN] * 100, "ahead": [AHEAD] * 60}
FLOOR = np.array([(0.6, 0.0, 0.1), (0.9, 0.6, 0.4), (0.1, 0.7, 1.9), (-0.5, 0.2, 3.0),
                  (0.2, -0.6, -1.5), (1.2, -0.3, 0.3), (1.6, 0.4, -0.2)])  # fmt: skip
"""Places and directions of pieces of tape."""
HALF = 0.35
"""Half of a piece's length [m]."""


def ranges_from(start: Pose2) -> Array:
    """Return the ranges to pieces of tape; inf where there is none within 0.9 m."""
    heading = start.theta + BEARINGS
    rays = np.column_stack([np.cos(heading), np.sin(heading)])
    nearest = np.full(len(rays), np.inf)
    for x, y, theta in FLOOR:
        along, across = np.array([math.cos(theta), math.sin(theta)]), np.zeros(2)
        across[:] = -along[1], along[0]
        middle = np.array([x - start.x, y - start.y])
        with np.errstate(divide="ignore"):
            reach = (middle @ across) / (rays @ across)
            beside = np.abs((rays * reach[:, None] - middle) @ along)
        nearest = np.where((reach > 0.03) & (beside < HALF), np.minimum(nearest, reach), nearest)
    return np.where(nearest < 0.9, nearest, np.inf)


def seen(twists: list[Twist2], *, mirrored: bool = False) -> Iterator[tuple[Scan, Pose2]]:
    """Return the scans of a drive, and where the robot was."""
    rng, pose = np.random.default_rng(4), Pose2()
    for number, twist in enumerate(twists):
        ranges = ranges_from(pose @ CENTRE) + rng.normal(0.0, NOISE, len(BEARINGS))
        yield Scan(number * PERIOD, BEARINGS, ranges[::-1] if mirrored else ranges, CENTRE), pose
        pose = pose @ twist.integrate(PERIOD)


def told(step: Pose2, plugs: Plugs, scale: tuple[float, float] = (1.0, 1.0)) -> Pose2:
    """Return a step as wheels tell it that are plugged in so, and are not as large as drawn."""
    way, half = math.copysign(math.hypot(step.x, step.y), step.x), step.theta * TRACK / 2
    truly = np.array([way - half, way + half])
    left, right = np.linalg.inv(np.array(plugs.value)) @ truly * scale
    return Twist2((left + right) / 2, (right - left) / TRACK).integrate(1.0)


def checked(twists: list[Twist2], plugs: Plugs, scale: tuple[float, float] = (1.0, 1.0)) -> Plugs:
    """Return what is found on a drive; it must not change once it is known."""
    check, odometry, found = PlugCheck(TRACK), Pose2(), Plugs.RIGHT
    for (scan, pose), (_, after) in pairwise(seen(twists)):
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
    for scan, pose in seen(BENDS, mirrored=True):
        check.add(scan, pose)
    assert check.plugs is Plugs.SWAPPED


def test_while_wheels_turn_and_the_robot_stands_nothing_is_named() -> None:
    for twists in (BENDS, [SPIN] * 100):
        check, odometry = PlugCheck(TRACK), Pose2()
        for (scan, _), twist in zip(seen([Twist2()] * len(twists)), twists, strict=True):
            check.add(scan, odometry)
            odometry = odometry @ twist.integrate(PERIOD)
            assert check.plugs is Plugs.RIGHT


def test_once_motors_are_plugged_in_rightly_that_is_seen() -> None:
    check, odometry = PlugCheck(TRACK), Pose2()
    found = []
    for number, ((scan, pose), (_, after)) in enumerate(pairwise(seen([LEFT] * 300))):
        check.add(scan, odometry)
        plugs = Plugs.SWAPPED if number < 150 else Plugs.RIGHT
        odometry = odometry @ told(pose.inverse() @ after, plugs)
        found.append(check.plugs)
    assert found[149] is Plugs.SWAPPED and found[-1] is Plugs.RIGHT


@pytest.mark.parametrize("elapsed", [0.0, -1.0, 2 * LONGEST])
def test_after_a_jump_in_time_comparing_begins_anew(elapsed: float) -> None:
    check = PlugCheck(TRACK)
    for number, (scan, pose) in enumerate(seen(BENDS, mirrored=True)):
        check.add(Scan(number * elapsed, scan.bearings, scan.ranges, CENTRE), pose)
    assert check.plugs is Plugs.RIGHT


@pytest.mark.parametrize("rays", [0, 1, 2, 12])
def test_scans_of_few_rays_tell_nothing(rays: int) -> None:
    check = PlugCheck(TRACK)
    for number in range(30):
        scan = Scan(number * PERIOD, np.linspace(-0.5, 0.5, rays), np.full(rays, 0.4))
        check.add(scan, Pose2(theta=0.1 * number))
    assert check.plugs is Plugs.RIGHT
