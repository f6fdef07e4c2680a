"""Exploring: routes are driven to their ends; floors are seen whole, or not said to be."""

import math

import numpy as np
import pytest
from explored_floor import DrawnFloor, explored, next_route, rectangle
from hypothesis import given
from hypothesis import strategies as st

from robot.driving.route import CLOSE, SPEED, TURNING, Route
from robot.geometry import Pose2
from robot.mapping.exploring import MOST_LOOKS, OUTSIDE, Explorer, _large

TICK = 0.02
SQUARE = rectangle(-0.5, -0.5, 0.5, 0.5)
LONGEST_S = 60.0
MOST_TAPE = 0.98
"""Some centimetres at a corner may be missing: only what is farther than its width is driven to."""


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


def test_the_square_is_looked_around_and_left_soon() -> None:
    floor = DrawnFloor([SQUARE])
    drive = explored(floor, Pose2(0.1, -0.2, 0.3))
    assert floor.share == 1.0
    assert len(drive.unseen) == 0
    assert drive.seconds < 120.0
    assert drive.path[-1].distance_to(Pose2(0.1, -0.2)) < 0.05
    # It leaves the tape, but not the floor around it.
    farthest = max(max(abs(pose.x), abs(pose.y)) for pose in drive.path)
    assert 0.6 < farthest < 0.5 + OUTSIDE + 2 * CLOSE


@pytest.mark.parametrize("gap", [0.4, 0.7, 1.0])
def test_an_island_is_found(gap: float) -> None:
    floor = DrawnFloor(
        [rectangle(-0.35, -0.35, 0.35, 0.35), rectangle(0.4 + gap, -0.3, 1.1 + gap, 0.4)]
    )
    drive = explored(floor, Pose2())
    assert floor.share > MOST_TAPE
    assert len(drive.unseen) == 0


def test_floor_that_tape_hides_is_driven_to() -> None:
    """It was in view over the tape, so the robot never drove to the other side."""
    wall = np.array([[0.0, -0.5], [0.0, 0.5]])
    mark = np.array([[0.2, 0.0], [0.4, 0.0]])
    floor = DrawnFloor([SQUARE, wall, mark])
    explored(floor, Pose2(-0.25, 0.0, 0.0))
    assert floor.share > MOST_TAPE


def test_tape_that_leads_on_is_followed() -> None:
    """Rooms in a row: tape goes on behind each wall."""
    lines = [rectangle(0.8 * room, 0.0, 0.8 * (room + 1), 0.7) for room in range(4)]
    floor = DrawnFloor(lines)
    explored(floor, Pose2(0.4, 0.35, 0.0))
    assert floor.share > MOST_TAPE


def test_a_robot_that_sees_a_single_straight_line_first_goes_on() -> None:
    floor = DrawnFloor([SQUARE])
    drive = explored(floor, Pose2(-0.55, 0.0, math.pi))
    assert floor.share > MOST_TAPE and len(drive.unseen) == 0


def test_what_is_never_shown_is_told_and_not_looked_at_for_ever() -> None:
    floor = DrawnFloor([SQUARE], dark=(0.1, 0.1, 0.45, 0.45))
    drive = explored(floor, Pose2())
    assert len(drive.unseen)
    assert np.abs(drive.unseen - 0.27).max() < 0.25
    assert drive.seconds < 150.0


def test_a_map_that_changes_with_each_look_comes_to_an_end() -> None:
    explorer, pose, rng = Explorer(), Pose2(), np.random.default_rng(3)
    for _ in range(MOST_LOOKS + 3):
        side = 0.4 + 0.2 * rng.random()
        floor = DrawnFloor([rectangle(-side, -side, side, side)])
        floor.seen[:] = True
        route = next_route(explorer, floor, pose)
        if route is None:
            break
        pose = route.goal
    assert route is None


def test_without_tape_it_gives_up_after_a_look_around() -> None:
    explorer = Explorer()
    assert explorer.next(None, Pose2(), None) is not None
    assert explorer.next(None, Pose2(), None) is None


@pytest.mark.parametrize("place", [0.0, 0.025, 0.05, 0.075, 0.1, 0.125])
def test_a_patch_that_was_not_seen_is_told_wherever_it_lies(place: float) -> None:
    corner = np.array([place, 0.6 - place])
    patch = corner + 0.05 * np.stack(np.meshgrid(range(3), range(3)), axis=-1).reshape(-1, 2)
    (told,) = _large(patch, np.ones(len(patch)), 0.05, 6.0)
    np.testing.assert_allclose(told, corner + 0.05)
    assert len(_large(patch[:5], np.ones(5), 0.05, 6.0)) == 0
