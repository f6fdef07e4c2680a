"""A navigator by itself: an ideal robot, and beliefs that are made up."""

import math
from dataclasses import replace

import numpy as np
import pytest

from app.settings.config import MAPS
from robot.description.spec import RobotSpec
from robot.fields.field_loading import load_field
from robot.geometry import Pose2, Twist2
from robot.localization.estimate import Integrity, State
from robot.navigation.arrival import VAGUE_M, VAGUE_RAD
from robot.navigation.free_space import FreeSpace
from robot.navigation.goal import Goal
from robot.navigation.legs import turn
from robot.navigation.looking_around import MOST_MOVES
from robot.navigation.lookout import Move
from robot.navigation.navigator import Navigator
from robot.navigation.planning import NoWayError
from robot.navigation.possible_places import Glimpse
from robot.navigation.sensed import Sensed
from robot.navigation.settings import NavigationSettings
from robot.navigation.timed_way import Limits
from robot.scan import Scan

TICK = 0.02
SURE = Integrity(State.CERTAIN, 0.01, 0.02)
LIMITS = Limits(0.2, 0.48, 0.5, 1.8, 3.2, 0.33, 0.056)
SETTINGS = NavigationSettings(command_lag=0.02)
SCAN = Scan(0.0, np.zeros(1), np.full(1, math.inf))
FREE = FreeSpace.of(load_field("square", MAPS), RobotSpec.load().outline, SETTINGS)


class Ideal:
    """A robot that does at once what it is told."""

    def __init__(self, *goals: Goal, repeat=False, settings=SETTINGS) -> None:
        self.navigator = Navigator(goals, settings, LIMITS, look=self.look, repeat=repeat)
        self.pose, self.twist, self.stamp = Pose2(), Twist2(), 0.0
        self.believed = SURE
        self.spread = 0.0
        self.pulled: Goal | None = None
        """Where what it sees leads 1.5 mm aside."""
        self.looks: list[tuple[int, int]] = []
        self.told: tuple[float, ...] = (1.0, -2.0)
        """The turns that looking around finds, one after the other."""
        self.states: list[tuple[str, str]] = []

    @property
    def status(self):
        return self.navigator.status

    def look(self, views, here, places, dares):
        self.looks.append((len(views), dares))
        count = len(self.looks) - 1
        if count >= len(self.told):
            return Move((), "no move would tell it more")
        return Move((turn(here, here.theta + self.told[count]),), "a move tells")

    def tick(self, *, hold=False) -> None:
        self.stamp += TICK
        pulled = self.pulled
        if pulled is not None and math.dist((self.pose.x, self.pose.y), pulled[:2]) < 0.002:
            estimate = self.pose @ Pose2(0.0, 0.0015)
        else:
            estimate = self.pose
        now = Sensed(
            self.stamp, estimate, self.twist, self.believed, self.pose,
            Glimpse(self.pose, SCAN), spread=self.spread,
        )  # fmt: skip
        job = self.navigator.job(lambda: FREE, now)
        if job is not None:
            try:
                self.navigator.take(job())
            except NoWayError as error:
                self.navigator.take(error)
        if hold:
            self.navigator.hold(now)
        self.twist = Twist2() if hold else self.navigator.step(now)
        self.pose = self.pose @ self.twist.integrate(TICK)
        if not self.states or self.states[-1] != (self.status.state, self.status.reason):
            self.states.append((self.status.state, self.status.reason))

    def go(self, seconds: float) -> None:
        for _ in range(round(seconds / TICK)):
            if not self.status.active:
                return
            self.tick()


@pytest.mark.parametrize(
    "goal", [(0.3, 0.2, 2.0), (-0.2, 0.1, 0.0), (0.01, 0.0, 0.0), (0.0, 0.0, 3.0), (0.0, 0.003, 0)]
)
def test_it_arrives_within_its_tolerances(goal):
    robot = Ideal(Goal(*goal))
    robot.go(60)
    assert robot.status.state == "arrived"
    assert robot.pose.distance_to(Pose2(*goal)) <= SETTINGS.xy_goal_tolerance
    assert abs(robot.pose.turn_to(Pose2(*goal))) <= SETTINGS.yaw_goal_tolerance
    assert robot.twist == Twist2()
    assert [state for state, _ in robot.states] in (
        ["planning", "driving", "arrived"],
        ["driving", "arrived"],
        ["driving", "planning", "driving", "arrived"],
    )


@pytest.mark.parametrize(
    ("spread", "end"),
    [(0.0007, ("arrived", "its place is known to 10 mm only")), (0.0002, ("failed", "it stands"))],
)
def test_an_end_that_its_estimate_may_err_by_is_an_arrival_that_says_so(spread, end):
    """It came to its goal seven times, each time to see there that it is 1.5 mm beside it."""
    goal = Goal(0.3, 0.2, 1.0)
    robot = Ideal(goal)
    robot.pulled, robot.spread = goal, spread
    robot.go(60)
    assert robot.status.state == end[0]
    assert robot.status.reason.startswith(end[1])


def test_a_place_without_a_heading_is_reached_with_any():
    robot = Ideal(Goal(0.2, -0.1))
    robot.go(60)
    assert robot.status.state == "arrived"
    assert math.dist((robot.pose.x, robot.pose.y), (0.2, -0.1)) <= SETTINGS.xy_goal_tolerance


def test_several_goals_are_passed_in_their_order_and_again_if_wanted():
    robot = Ideal(Goal(0.2, 0.0, 0.0), Goal(0.2, 0.2, 1.5), repeat=True)
    passed = []
    for _ in range(3000):
        robot.tick()
        if not passed or passed[-1] != robot.status.number:
            passed.append(robot.status.number)
    assert passed[:5] == [0, 1, 0, 1, 0]
    assert robot.status.active


def test_it_says_what_is_left_and_that_is_right():
    robot = Ideal(Goal(0.35, 0.0, 0.0))
    robot.tick()
    robot.tick()
    seconds, way = robot.status.remaining_s, robot.status.remaining_m
    began = robot.stamp
    assert way == pytest.approx(0.35, abs=0.005)
    robot.go(60)
    assert robot.stamp - began == pytest.approx(seconds, abs=1.0)


@pytest.mark.parametrize("state", [State.LOST, State.SEARCHING, State.AMBIGUOUS])
def test_without_a_place_it_looks_around_then_stands_and_drives_on_when_it_knows(state):
    robot = Ideal(Goal(0.3, 0.2, 2.0))
    robot.go(2.5)
    assert robot.status.state == "driving"
    robot.believed = Integrity(state)
    robot.tick()
    place = robot.pose
    assert robot.status.state == "waiting"
    assert robot.twist == Twist2()
    robot.go(30)
    assert any("looks around, a move tells" in reason for _, reason in robot.states)
    assert robot.twist == Twist2()
    assert "no move would tell it more" in robot.status.reason
    assert robot.pose.distance_to(place) < 1e-9
    assert robot.pose.theta == pytest.approx(place.theta - 1.0, abs=0.01)
    assert [count for count, _ in robot.looks[:5]] == [1, 2, 3, 3, 3]
    assert [dares for _, dares in robot.looks[:5]] == [0, 0, 0, 1, 2]
    robot.believed = SURE
    robot.go(60)
    assert robot.status.state == "arrived"
    assert robot.pose.distance_to(Pose2(0.3, 0.2)) <= SETTINGS.xy_goal_tolerance


@pytest.mark.parametrize("state", [State.LOST, State.SEARCHING, State.AMBIGUOUS])
def test_a_goal_that_no_way_leads_to_from_a_wrong_place_is_not_given_up(state):
    robot = Ideal(Goal(0.3, 0.2, 2.0))
    robot.pose, robot.believed = Pose2(0.75, 0.0), Integrity(state)  # beyond the tape
    robot.go(2.0)
    assert robot.status.state == "waiting"
    robot.pose, robot.believed = Pose2(), SURE
    robot.go(60)
    assert robot.status.state == "arrived"


def test_it_looks_around_a_number_of_times_and_then_waits():
    robot = Ideal(Goal(0.3, 0.2, 2.0))
    robot.told = (0.1, -0.1) * 50
    robot.go(1.0)
    robot.believed = Integrity(State.LOST)
    robot.go(120)
    assert len(robot.looks) == MOST_MOVES
    assert robot.twist == Twist2()
    assert "waits until it knows better" in robot.status.reason


def test_it_stands_at_once_while_its_place_is_in_doubt_and_then_drives_on():
    robot = Ideal(Goal(0.3, 0.2, 2.0))
    robot.go(2.5)
    robot.believed = Integrity(State.APPROXIMATE, math.inf, 0.1)
    robot.tick()
    assert (robot.twist, robot.status.state) == (Twist2(), "waiting")
    assert "in doubt" in robot.status.reason
    robot.go(0.5)
    robot.believed = SURE
    robot.tick()
    assert robot.status.state == "driving"
    assert not robot.looks


def time_to(goal, radius):
    robot = Ideal(Goal(*goal))
    robot.believed = Integrity(State.APPROXIMATE, radius, 0.1)
    while robot.status.remaining_m > 0.03 or robot.status.state == "planning":
        robot.tick()
    return robot.stamp


def test_it_is_slower_where_its_outline_grown_by_the_bound_comes_to_walls():
    beside, amid = (0.35, 0.0, 0.0), (0.15, 0.0, 0.0)
    assert time_to(beside, 0.14) > 1.15 * time_to(beside, 0.01)
    assert time_to(amid, 0.14) == time_to(amid, 0.01)


def test_a_robot_that_was_pushed_plans_anew_and_arrives():
    robot = Ideal(Goal(0.35, 0.0, 0.0))
    robot.go(2.0)
    robot.pose = Pose2(robot.pose.x, 0.2, -1.0)
    robot.go(60)
    assert robot.status.state == "arrived"
    assert ("planning", "") in robot.states[1:]


def test_beside_its_goal_it_has_not_arrived_though_there_is_no_room_to_correct_it(monkeypatch):
    monkeypatch.setattr("robot.navigation.next_way.corrected", lambda *_: ())
    robot = Ideal(Goal(0.35, 0.0, 0.0))
    robot.go(1.0)
    while robot.status.remaining_s > 0.01:
        robot.tick()
    robot.pose = Pose2(robot.pose.x, 0.006, robot.pose.theta)
    robot.go(60)
    assert robot.status.state == "arrived"
    assert robot.pose.distance_to(Pose2(0.35, 0.0)) <= SETTINGS.xy_goal_tolerance


@pytest.mark.parametrize(
    ("radius", "bound", "theta", "words"),
    [
        (VAGUE_M, VAGUE_RAD, 2.0, ""),
        (0.061, 0.02, 2.0, "its place is known to 70 mm only"),
        (0.01, 0.1, 2.0, "its heading is known to 6 degrees only"),
        (0.01, 0.1, None, ""),
    ],
)
def test_when_it_arrives_it_says_what_it_does_not_know_well(radius, bound, theta, words):
    robot = Ideal(Goal(0.1, 0.1, theta))
    robot.believed = Integrity(State.CERTAIN, radius, bound)
    robot.go(60)
    assert (robot.status.state, robot.status.reason) == ("arrived", words)


def test_without_a_way_it_fails_and_says_why():
    robot = Ideal(Goal(0.5, 0.0, 0.0))
    robot.go(1)
    assert robot.status.state == "failed"
    assert "on a wall" in robot.status.reason


def test_held_it_stands_and_goes_on_where_it_was():
    robot = Ideal(Goal(0.35, 0.0, 0.0))
    robot.go(1.5)
    left = robot.status.remaining_s
    for _ in range(100):
        robot.tick(hold=True)
    assert robot.status.state == "waiting"
    assert robot.status.remaining_s == pytest.approx(left, abs=0.03)
    robot.go(60)
    assert robot.status.state == "arrived"


def test_a_canceled_journey_says_so_once():
    robot = Ideal(Goal(0.35, 0.0, 0.0))
    robot.go(1.5)
    robot.navigator.cancel("a test ends it")
    robot.navigator.cancel("again")
    assert (robot.status.state, robot.status.reason) == ("canceled", "a test ends it")
    robot.tick()
    assert robot.twist == Twist2()


@pytest.mark.parametrize("narrow_ways", ["told", "refused"])
def test_a_bound_that_grows_beside_tape_ends_a_drive_only_where_that_is_refused(narrow_ways):
    robot = Ideal(Goal(0.385, 0.0, 0.0), settings=replace(SETTINGS, narrow_ways=narrow_ways))
    while robot.pose.x < 0.3:
        robot.tick()
    robot.believed = Integrity(State.CERTAIN, 0.04, 0.02)
    robot.go(30)
    if narrow_ways == "told":
        assert robot.status.state == "arrived"
        return
    assert robot.status.state == "failed"
    assert robot.status.reason.endswith("nearer than the 40 mm to which its place is known")
    assert FREE.room(robot.pose.to_array()[None])[0] > 0.02
    assert robot.twist == Twist2()


def test_a_goal_nearer_to_tape_than_the_bound_is_driven_to_and_told_meanwhile():
    robot = Ideal(Goal(0.385, 0.0, 0.0))
    robot.believed = Integrity(State.CERTAIN, 0.03, 0.02)
    robot.go(30)
    assert robot.status.state == "arrived"
    assert (
        "driving",
        "at the goal a wall is nearer than the 30 mm to which its place is known",
    ) in (robot.states)
