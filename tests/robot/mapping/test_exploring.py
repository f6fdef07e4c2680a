"""Exploring: routes are driven to their ends, and views are chosen where floor was not seen."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robot.driving.route import SPEED, TURNING, Route
from robot.geometry import Pose2
from robot.mapping.exploring import Explorer, best_view
from robot.mapping.sketch import Sketch

TICK = 0.02
SIDE = np.array([[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5], [-0.5, -0.5]])
LONGEST_S = 60.0


def driven(route: Route, pose: Pose2) -> tuple[Pose2, float]:
    """Where a robot with exact wheels ends, and how long that takes [s]."""
    for tick in range(round(LONGEST_S / TICK)):
        twist = route.twist(pose)
        if twist is None:
            return pose, tick * TICK
        assert 0 <= twist.v <= SPEED
        assert abs(twist.omega) <= TURNING
        pose = pose @ twist.integrate(TICK)
    raise AssertionError(f"the route does not end: {pose}")


def sketch(*poses: tuple[float, float, float], lines: tuple[np.ndarray, ...] = (SIDE,)) -> Sketch:
    path = np.array(poses)
    edges = np.vstack(lines)
    return Sketch(lines, np.zeros(len(lines)), path, edges, float(len(path)), None)


coordinates = st.floats(-1, 1)
poses = st.builds(Pose2, coordinates, coordinates, st.floats(-3.1, 3.1))


@given(poses, poses)
def test_a_route_ends_at_its_goal(start: Pose2, goal: Pose2) -> None:
    end, _ = driven(Route(goal), start)
    assert end.distance_to(goal) < 0.05
    assert abs(math.remainder(end.theta - goal.theta, math.tau)) < 0.06


def test_a_turn_goes_all_the_way_around() -> None:
    end, seconds = driven(Route(Pose2(), turn=math.tau), Pose2())
    assert end.distance_to(Pose2()) < 1e-9
    assert seconds > 0.95 * math.tau / TURNING


def test_a_view_shows_what_is_new_and_lies_within_the_tape() -> None:
    # All of the square was seen but its left part.
    right = [
        (x, y, heading)
        for x in (0.1, 0.25, 0.4)
        for y in (-0.4, -0.2, 0.0, 0.2, 0.4)
        for heading in np.arange(-3, 3, 0.5)
        if heading == pytest.approx(0, abs=1.1)
    ]
    view = best_view(sketch(*right), np.zeros((0, 3)), Pose2(0.3, 0.0, 0.0))
    assert view is not None
    assert max(abs(view.x), abs(view.y)) <= 0.41
    ahead = view @ Pose2(0.3, 0.0, 0.0)
    assert ahead.x < 0.15


def test_it_begins_with_a_look_around_and_ends_where_it_began() -> None:
    explorer, pose, path = Explorer(), Pose2(0.1, -0.2, 0.3), [(0.1, -0.2, 0.3)]
    goals = []
    while (route := explorer.next(sketch(*path), pose)) is not None:
        goals.append(route.goal)
        if route.turn:
            path += [(0.1, -0.2, 0.3 + turn) for turn in np.arange(0, math.tau, 0.2)]
        pose = route.goal
        path.append((pose.x, pose.y, pose.theta))
        assert len(goals) < 40
    assert goals[0] == goals[-1] == Pose2(0.1, -0.2, 0.3)
    assert len(goals) > 4


def test_without_tape_it_gives_up_after_a_look_around() -> None:
    explorer = Explorer()
    assert explorer.next(None, Pose2()) is not None
    assert explorer.next(None, Pose2()) is None


def test_an_end_that_nobody_saw_is_looked_at() -> None:
    everywhere = [
        (x, y, heading)
        for x in np.arange(-0.4, 0.41, 0.2)
        for y in np.arange(-0.4, 0.41, 0.2)
        for heading in np.arange(0, math.tau, 0.4)
    ]
    assert best_view(sketch(*everywhere), np.zeros((0, 3)), Pose2()) is None
    leading_out = np.array([[0.3, 0.0], [0.95, 0.0]])
    view = best_view(sketch(*everywhere, lines=(SIDE, leading_out)), np.zeros((0, 3)), Pose2())
    assert view is not None
    assert view.distance_to(Pose2(1.0, 0.0, 0.0)) < 0.6
