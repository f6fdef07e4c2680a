"""Ways to goals: they arrive, and the robot touches nothing on them."""

import numpy as np
import pytest

from app.settings.config import MAPS
from robot.description.spec import RobotSpec
from robot.fields.field_loading import load_field
from robot.fields.svg_field import field_of_drawing
from robot.geometry import Pose2
from robot.navigation.free_space import FreeSpace
from robot.navigation.gates import SAME_ROOM
from robot.navigation.planning import NoWayError, plan, require_free
from robot.navigation.settings import NavigationSettings
from robot.navigation.timed_way import Limits, timed

LIMITS = Limits(0.2, 0.48, 0.5, 1.8, 3.2, 0.33, 0.056)


def space(name: str, **settings) -> FreeSpace:
    outline = RobotSpec.load().outline
    return FreeSpace.of(load_field(name, MAPS), outline, NavigationSettings(**settings))


@pytest.fixture(scope="module")
def square() -> FreeSpace:
    return space("square")


@pytest.mark.parametrize("name", ["square", "tee", "town"])
def test_ways_to_random_goals_arrive_and_keep_their_clearance(name):
    field, free = load_field(name, MAPS), space(name)
    rng = np.random.default_rng(5)
    here, planned = field.start, 0
    for pose in field.free_poses(rng, 300):
        goal = Pose2.from_array(pose)
        try:
            legs = plan(free, here, goal)
        except NoWayError:
            continue
        planned += 1
        poses = timed(legs, LIMITS).poses
        assert Pose2.from_array(poses[0]).distance_to(here) < 1e-6
        end = Pose2.from_array(poses[-1])
        assert end.distance_to(goal) < 1e-6
        assert abs(end.turn_to(goal)) < 0.003
        # Two cells of a diagonal less: clearance is that of the nearest cell.
        assert free.room(poses).min() > free.settings.clearance - 2 * free.side
        assert np.hypot(*np.diff(poses[:, :2], axis=0).T).max() < 0.01
        here = goal
    assert planned > 20


def test_a_goal_close_to_tape_is_come_to_straight(square):
    """There the robot could not turn."""
    goal = Pose2(0.385, 0.0, 0.0)
    assert not square.turns(goal.to_array()[None, :2])
    legs = plan(square, Pose2(), goal)
    assert legs[-1].poses[-1].tolist() == pytest.approx([0.385, 0.0, 0.0])
    assert all(square.fits(leg.poses) for leg in legs)


def test_a_robot_that_stands_close_to_tape_leaves_it_straight(square):
    start = Pose2(0.385, 0.0, 0.0)
    legs = plan(square, start, Pose2(-0.2, 0.1, 1.0))
    assert legs[0].backwards
    assert all(square.fits(leg.poses) for leg in legs)


def test_nothing_is_to_be_done_where_the_robot_stands(square):
    assert plan(square, Pose2(0.1, 0.2, 0.3), Pose2(0.1, 0.2, 0.3)) == ()
    (only,) = plan(square, Pose2(0.1, 0.2, 0.3), Pose2(0.1, 0.2, 2.3))
    assert only.on_spot


@pytest.mark.parametrize(
    ("goal", "words"),
    [
        (Pose2(0.5, 0.0), "would stand on a wall"),
        (Pose2(3.0, 0.0), "would stand on a wall"),
        (Pose2(0.402, 0.0), "nearer to a wall than 8 mm"),
        (Pose2(0.65, 0.65, 0.8), "a wall is between"),
    ],
)
def test_a_goal_where_the_robot_cannot_be_is_refused_with_its_reason(square, goal, words):
    with pytest.raises(NoWayError, match=words):
        plan(square, Pose2(), goal)


def test_a_goal_beyond_the_tape_has_no_way():
    free = space("square", clearance=0.0)
    goal = Pose2(0.64, 0.0, 1.57)
    require_free(free, goal)
    with pytest.raises(NoWayError):
        plan(free, Pose2(), goal)


def test_a_way_leads_around_a_wall():
    drawing = (
        '<svg xmlns="http://www.w3.org/2000/svg" width="1500mm" height="1500mm" '
        'viewBox="-750 -750 1500 1500"><rect x="-750" y="-750" width="1500" height="1500" '
        'fill="#ddd"/><path d="M 0 -725 V 200 M -725 -725 H 725 V 725 H -725 Z" fill="none" '
        'stroke="#111" stroke-width="30"/></svg>'
    )
    field = field_of_drawing(drawing, "wall")
    free = FreeSpace.of(field, RobotSpec.load().outline, NavigationSettings())
    legs = plan(free, Pose2(-0.3, 0.3, 0.0), Pose2(0.3, 0.3, 0.0))
    poses = np.concatenate([leg.poses for leg in legs])
    # The drawing's y points down: the wall reaches from above to y = -0.2.
    assert poses[:, 1].min() < -0.2 - free.radius
    assert 1.4 < sum(leg.length for leg in legs) < 2.0


def test_a_robot_beside_tape_turns_a_part_to_get_away():
    free = space("square")
    start, goal = Pose2(0.432, 0.3, 0.0), Pose2(0.0, 0.0, 1.0)
    assert not free.turns(start.to_array()[None, :2])
    legs = plan(free, start, goal)
    assert legs[-1].end.distance_to(goal) < 1e-6
    room = float(free.room(start.to_array()[None])[0])
    for leg in legs:
        assert free.room(leg.poses).min() >= min(free.settings.clearance, room) - SAME_ROOM


def test_a_robot_that_was_put_on_tape_leaves_it_and_does_not_come_back_to_it():
    free = space("square")
    start = Pose2(0.46, 0.0, 0.0)
    assert free.stands_in_wall(start)
    legs = plan(free, start, Pose2(0.0, 0.0, 1.0))
    room = np.concatenate([free.room(leg.poses) for leg in legs])
    clear = np.flatnonzero(room > 0)[0]
    assert (room[clear:] > 0).all()
