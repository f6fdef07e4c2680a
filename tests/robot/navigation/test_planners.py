"""Planners by name: each finds ways that fit; the lattice never turns on the spot."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.settings.config import MAPS
from robot.description.spec import RobotSpec
from robot.fields.field_loading import load_field
from robot.geometry import Pose2, wrap_angle
from robot.navigation.dubins import along_arcs, shortest_arcs
from robot.navigation.free_space import FreeSpace
from robot.navigation.planners import PLANNERS
from robot.navigation.planning import NoWayError, plan
from robot.navigation.settings import NavigationSettings

SETTINGS = NavigationSettings()
FREE = FreeSpace.of(load_field("square", MAPS), RobotSpec.load().outline, SETTINGS)
PLACES = st.builds(
    Pose2, st.floats(-0.3, 0.3), st.floats(-0.3, 0.3), st.floats(-3.1, 3.1)
)  # inside the square's tape


@pytest.mark.parametrize("name", PLANNERS)
@pytest.mark.parametrize("goal", [(0.3, 0.2, 2.0), (-0.2, -0.3, 0.0), (-0.1, 0.0, 3.0)])
def test_each_finds_a_way_that_fits_and_ends_at_the_goal(name, goal):
    start, end = Pose2(-0.25, 0.25, -0.5), Pose2(*goal)
    legs = PLANNERS[name].plan(FREE, start, end)
    assert legs[0].poses[0] == pytest.approx(start.to_array())
    assert legs[-1].end.distance_to(end) < 1e-6
    assert abs(legs[-1].end.turn_to(end)) < 1e-6
    for leg, following in pairwise(legs):
        assert leg.end.distance_to(Pose2.from_array(following.poses[0])) < 1e-9
    for leg in legs:
        assert FREE.fits(leg.poses)


@settings(max_examples=30, deadline=None)
@given(start=PLACES, goal=PLACES)
def test_the_lattice_drives_bends_of_its_radius_and_never_turns_on_the_spot(start, goal):
    if not (FREE.fits(start.to_array()[None]) and FREE.fits(goal.to_array()[None])):
        return
    try:
        legs = PLANNERS["lattice"].plan(FREE, start, goal)
    except NoWayError:
        return
    for leg in legs:
        assert not leg.on_spot
        way = np.hypot(*np.diff(leg.poses[:, :2], axis=0).T)
        turned = np.abs(np.diff(leg.poses[:, 2]))
        assert (turned <= way / SETTINGS.minimum_turning_radius * 1.02 + 1e-6).all()
        ahead = np.diff(leg.poses[:, :2], axis=0)
        middle = (leg.poses[:-1, 2] + leg.poses[1:, 2]) / 2 + (np.pi if leg.backwards else 0)
        off = wrap_angle(np.arctan2(ahead[:, 1], ahead[:, 0]) - middle)
        assert (np.abs(off)[way > 1e-6] < 0.02).all()


@pytest.fixture(scope="module")
def fields() -> dict[str, FreeSpace]:
    outline = RobotSpec.load().outline
    names = ("square", "stub", "tee", "town")
    return {name: FreeSpace.of(load_field(name, MAPS), outline, SETTINGS) for name in names}


def _fitting(free: FreeSpace, rng: np.random.Generator) -> Pose2:
    while True:
        xmin, ymin, xmax, ymax = free.extent
        x, y, theta = rng.uniform((xmin, ymin, -np.pi), (xmax, ymax, np.pi)).tolist()
        if free.fits(np.array([[x, y, theta]])):
            return Pose2(x, y, theta)


@settings(max_examples=60, deadline=None)
@given(name=st.sampled_from(["square", "stub", "tee", "town"]), seed=st.integers(0, 2**32 - 1))
def test_cells_find_a_way_wherever_headings_do_and_it_keeps_its_clearance(fields, name, seed):
    free, rng = fields[name], np.random.default_rng(seed)
    start, goal = (_fitting(free, rng) for _ in range(2))
    try:
        PLANNERS["lattice"].plan(free, start, goal)
    except NoWayError:
        return
    legs = PLANNERS["grid"].plan(free, start, goal)
    # Two cells of a diagonal less: clearance is that of the nearest cell.
    least = min((float(free.room(leg.poses).min()) for leg in legs), default=1.0)
    assert least > SETTINGS.clearance - 2 * free.side


def test_where_it_fits_but_cannot_turn_cells_leave_it_to_headings(fields):
    start, goal = Pose2(0.366, 0.151, -1.691), Pose2()
    with pytest.raises(NoWayError):
        plan(fields["tee"], start, goal)
    legs = PLANNERS["grid"].plan(fields["tee"], start, goal)
    assert legs[-1].end.distance_to(goal) < 1e-6


def test_by_headings_a_robot_on_tape_leaves_it_and_does_not_come_back_to_it():
    start = Pose2(0.46, 0.0, 0.0)
    assert FREE.stands_in_wall(start)
    legs = PLANNERS["lattice"].plan(FREE, start, Pose2(0.0, 0.0, 1.0))
    room = np.concatenate([FREE.room(leg.poses) for leg in legs])
    clear = np.flatnonzero(room > 0)[0]
    assert (room[clear:] > 0).all()
    beyond = Pose2(0.5, 0.0, 1.57)
    with pytest.raises(NoWayError, match="stands on a wall"):
        PLANNERS["lattice"].plan(FREE, beyond, Pose2(0.0, 0.0, 1.0))


@given(
    start=st.builds(Pose2, st.floats(-1, 1), st.floats(-1, 1), st.floats(-3, 3)),
    goal=st.builds(Pose2, st.floats(-1, 1), st.floats(-1, 1), st.floats(-3, 3)),
    radius=st.floats(0.05, 0.5),
)
def test_arcs_end_at_the_goal_and_are_no_shorter_than_a_straight_line(start, goal, radius):
    arcs = shortest_arcs(start.to_array(), goal.to_array(), radius)
    way = along_arcs(start.to_array(), arcs, radius, 0.005)
    end = Pose2.from_array(way[-1])
    assert end.distance_to(goal) < 1e-6
    assert abs(end.turn_to(goal)) < 1e-6
    assert radius * (arcs[1] + arcs[4]) + arcs[2] >= start.distance_to(goal) - 1e-9


@pytest.mark.parametrize("name", PLANNERS)
def test_each_says_that_there_is_no_way(name):
    beyond = Pose2(0.62, 0.0, 0.0)  # on the floor outside the tape
    with pytest.raises(NoWayError):
        PLANNERS[name].plan(FREE, Pose2(), beyond)
