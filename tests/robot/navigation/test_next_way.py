"""Ways keep the bound of the robot's place from walls; where none does, that is told or refused."""

from dataclasses import replace

import numpy as np
import pytest

from app.settings.config import MAPS
from robot.description.spec import RobotSpec
from robot.fields.field_loading import load_field
from robot.geometry import Pose2
from robot.navigation.free_space import FreeSpace
from robot.navigation.goal import Goal
from robot.navigation.next_way import Approach, Planning, way_to
from robot.navigation.planners import find_way
from robot.navigation.planning import NoWayError
from robot.navigation.settings import NavigationSettings
from robot.navigation.timed_way import Limits
from robot.navigation.walls import Walls

SETTINGS = NavigationSettings()
FIELD, OUTLINE = load_field("square", MAPS), RobotSpec.load().outline
SQUARE = FreeSpace.of(FIELD, OUTLINE, SETTINGS)
PLANNING = Planning(find_way, SETTINGS, Limits(0.2, 0.48, 0.5, 1.8, 3.2, 0.33, 0.056))
STRICT = replace(PLANNING, settings=replace(SETTINGS, narrow_ways="refused"))


def test_where_there_is_room_the_way_keeps_the_bound_of_the_place_from_walls() -> None:
    """The same goals, with less and less known of the place: the way stays away from the tape."""
    start, goal = Pose2(-0.25, 0.2, 0.0), Goal(0.25, 0.2, 0.0)
    for bound in (0.02, 0.04, 0.06):
        way = way_to(SQUARE, Approach(start, goal, bound=bound), PLANNING)
        assert way is not None
        assert way.narrow == ""
        assert SQUARE.room(way.poses).min() >= bound


def test_a_goal_beside_tape_is_driven_to_and_told_or_refused() -> None:
    pose = Pose2(0.0, 0.0, 0.0)
    goal = Goal(0.385, 0.0, 0.0)
    assert 0.01 < SQUARE.room(np.array([[*goal]]))[0] < 0.03
    approach = Approach(pose, goal, bound=0.03)
    way = way_to(SQUARE, approach, PLANNING)
    assert way is not None
    assert "nearer than the 30 mm to which its place is known" in way.narrow
    with pytest.raises(NoWayError, match="nearer than the 30 mm"):
        way_to(SQUARE, approach, STRICT)
    assert way_to(SQUARE, replace(approach, bound=0.01), STRICT) is not None


def test_a_passage_narrower_than_the_bound_is_told_or_refused() -> None:
    """Two zones leave a gap in which the robot has a little more than its clearance."""
    half = float(np.abs(OUTLINE[:, 1]).max()) + 0.02
    zones = tuple(
        ((-0.05, sign * half), (0.05, sign * half), (0.05, sign), (-0.05, sign)) for sign in (1, -1)
    )
    space = FreeSpace.of(FIELD, OUTLINE, SETTINGS, Walls(zones=zones))
    strict_space = FreeSpace.of(FIELD, OUTLINE, STRICT.settings, Walls(zones=zones))
    approach = Approach(Pose2(-0.2, 0.0, 0.0), Goal(0.2, 0.0, 0.0), bound=0.03)
    way = way_to(space, approach, PLANNING)
    assert way is not None
    assert way.narrow == "its way keeps no 30 mm from walls, to which its place is known"
    with pytest.raises(NoWayError, match="keeps no 30 mm"):
        way_to(strict_space, approach, STRICT)
    known_better = way_to(strict_space, replace(approach, bound=0.015), STRICT)
    assert known_better is not None
    assert known_better.narrow == ""


def test_where_no_way_leads_at_all_that_is_the_reason_also_where_narrow_ones_are_refused() -> None:
    strict_space = FreeSpace.of(FIELD, OUTLINE, STRICT.settings)
    beyond = Approach(Pose2(), Goal(0.5, 0.0, 0.0), bound=0.03)
    with pytest.raises(NoWayError, match="would stand on a wall"):
        way_to(strict_space, beyond, STRICT)
