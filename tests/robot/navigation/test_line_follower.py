"""Following tape by what is seen: an ideal robot, and scans of made-up tape."""

import math

import numpy as np
import pytest

from robot.geometry import Pose2, Twist2
from robot.localization.estimate import Integrity, State
from robot.navigation.line_follower import LineFollower
from robot.navigation.possible_places import Glimpse
from robot.navigation.sensed import Sensed
from robot.navigation.timed_way import Limits
from robot.scan import Scan

TICK, PICTURE_S = 0.04, 0.1
LIMITS = Limits(0.2, 0.48, 0.5, 1.8, 3.2, 0.33, 0.056)
BEARINGS = np.linspace(-0.5, 0.5, 61)
NEAR_M, FAR_M = 0.16, 0.45
HALF_M = 0.015
"""Half a tape's width."""


def away_from(parts, points):
    """Return the distance (n,) of points (n, 2) from a line of several parts (k, 2)."""
    away = np.full(len(points), np.inf)
    for start, end in zip(np.array(parts[:-1]), np.array(parts[1:]), strict=True):
        along = end - start
        share = np.clip((points - start) @ along / (along @ along), 0, 1)
        away = np.minimum(away, np.hypot(*(points - start - share[:, None] * along).T))
    return away


class Ideal:
    """A robot that does at once what it is told, and sees tape whose middle are some parts."""

    def __init__(self, parts, pose: Pose2) -> None:
        self.parts, self.pose, self.odom = parts, pose, Pose2(3.0, -2.0, 1.0)
        self.follower = LineFollower(0.12, LIMITS, name=7)
        self.stamp, self.twist = 0.0, Twist2()
        self.seen: Glimpse | None = None
        self.places: list[tuple[float, float]] = []

    def view(self) -> Glimpse:
        along = np.arange(NEAR_M, FAR_M, 0.004)
        headings = self.pose.theta + BEARINGS
        directions = np.column_stack([np.cos(headings), np.sin(headings)])
        points = (self.pose.x, self.pose.y) + directions[:, None] * along[:, None]
        dark = (away_from(self.parts, points.reshape(-1, 2)) < HALF_M).reshape(len(headings), -1)
        ranges = np.where(dark.any(axis=1), along[dark.argmax(axis=1)], np.inf)
        begins = dark[:, 0]
        ends = np.where((~dark).any(axis=1), along[(~dark).argmax(axis=1)], FAR_M)
        ranges[begins] = np.inf
        hidden = np.column_stack([np.where(begins, 0.0, np.inf), np.where(begins, ends, -np.inf)])
        sight = np.tile([NEAR_M, FAR_M], (len(BEARINGS), 1))
        return Glimpse(self.odom, Scan(self.stamp, BEARINGS, ranges, sight=sight, hidden=hidden))

    def go(self, seconds: float) -> None:
        for _ in range(round(seconds / TICK)):
            if not self.follower.status.active:
                return
            self.stamp += TICK
            if self.seen is None or self.stamp >= self.seen.scan.stamp + PICTURE_S:
                self.seen = self.view()
            nowhere = Integrity(State.LOST)
            tick = Sensed(self.stamp, None, self.twist, nowhere, self.odom, self.seen)
            self.twist = self.follower.step(tick)
            moved = self.twist.integrate(TICK)
            self.pose, self.odom = self.pose @ moved, self.odom @ moved
            self.places.append((self.pose.x, self.pose.y))

    @property
    def off(self) -> np.ndarray:
        return away_from(self.parts, np.array(self.places))


@pytest.mark.parametrize("heading", [0.0, 0.4, -0.4])
def test_it_follows_straight_tape_to_its_end_and_says_so(heading):
    robot = Ideal([(0.0, 0.0), (0.9, 0.0)], Pose2(-0.2, 0.0, heading))
    robot.go(30)
    assert (robot.follower.status.state, robot.follower.status.name) == ("arrived", 7)
    assert robot.twist == Twist2()
    assert abs(robot.pose.x - 0.9) < 0.1
    assert robot.off[-150:].max() < 0.03


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_it_goes_around_a_right_angled_corner(side):
    parts = [(0.0, 0.0), (0.6, 0.0), (0.6, 0.7 * side)]
    robot = Ideal(parts, Pose2(0.05, 0.0, 0.0))
    robot.go(30)
    assert robot.follower.status.state == "arrived"
    assert abs(robot.pose.y - 0.7 * side) < 0.1
    assert robot.off.max() < 0.08


@pytest.mark.parametrize("radius", [0.2, 0.4])
def test_it_goes_round_a_ring_until_somebody_ends_it(radius):
    around = np.linspace(0, 2 * math.pi, 25)
    ring = np.column_stack([radius * np.cos(around), radius * np.sin(around)])
    robot = Ideal([tuple(each) for each in ring], Pose2(radius, 0.0, math.pi / 2))
    robot.go(3 * math.pi * radius / 0.08)
    assert robot.follower.status.state == "driving"
    assert robot.off.max() < 0.04
    turned = np.unwrap(np.arctan2(*np.array(robot.places).T[::-1]))
    assert turned[-1] - turned[0] > 2 * math.pi
    robot.follower.cancel("a test ends it")
    robot.go(1)
    assert (robot.follower.status.state, robot.follower.status.reason) == (
        "canceled",
        "a test ends it",
    )


@pytest.mark.parametrize("crossed", [-60, -45, 90])
@pytest.mark.parametrize("heading", [-0.1, 0.1])
def test_where_tape_crosses_it_goes_straight_on(crossed, heading):
    angle = math.radians(crossed)
    across = 0.4 * np.array([math.cos(angle), math.sin(angle)])
    middle = np.array([0.45, 0.0])
    # One line that crosses itself: the loop back lies out of sight.
    parts = [(0.0, 0.0), (1.0, 0.0), (1.0, 3.0), tuple(middle + across), tuple(middle - across)]
    robot = Ideal(parts, Pose2(0.05, 0.0, heading))
    robot.go(8.0)
    assert robot.pose.x > 0.6
    assert np.abs(np.array(robot.places)[:, 1]).max() < 0.04


@pytest.mark.parametrize("heading", [-0.1, 0.1])
def test_where_tape_ends_at_another_it_goes_on_to_one_side_to_its_end(heading):
    parts = [(0.0, 0.0), (0.5, 0.0), (0.5, 0.6), (0.5, -0.6)]
    robot = Ideal(parts, Pose2(0.05, 0.0, heading))
    robot.go(40)
    assert robot.follower.status.state == "arrived"
    assert abs(robot.pose.x - 0.5) < 0.08
    assert abs(abs(robot.pose.y) - 0.6) < 0.1


def test_without_tape_it_stands_and_says_why():
    robot = Ideal([(5.0, 5.0), (6.0, 5.0)], Pose2())
    robot.go(5)
    assert robot.follower.status.state == "failed"
    assert "no tape is in sight" in robot.follower.status.reason
    assert robot.pose == Pose2()


def test_held_it_waits_and_then_goes_on():
    robot = Ideal([(0.0, 0.0), (0.9, 0.0)], Pose2(-0.2, 0.0, 0.0))
    robot.go(1)
    tick = Sensed(robot.stamp, None, Twist2(), Integrity(State.LOST), robot.odom, robot.view())
    robot.follower.hold(tick)
    assert robot.follower.status.state == "waiting"
    robot.go(30)
    assert robot.follower.status.state == "arrived"
