"""Tape that the robot sees itself: where it lies, and that no move comes to it."""

import math

import numpy as np
import pytest

from app.settings.config import MAPS
from robot.description.spec import RobotSpec
from robot.fields.field_loading import load_field
from robot.geometry import Pose2
from robot.navigation.free_space import FreeSpace
from robot.navigation.lookout import AHEAD, RISKS, SEEN_MARGIN_M, ClearFloor, look, sweeps_of
from robot.navigation.place_kernels import steps_clear
from robot.navigation.possible_places import Glimpse
from robot.navigation.seen_tape import tape_in, tape_seen
from robot.navigation.settings import NavigationSettings
from robot.navigation.walls import Walls
from robot.scan import Scan

BEARINGS = np.linspace(-0.5, 0.5, 61)
SIGHT = np.tile([0.16, 0.7], (61, 1))
SETTINGS = NavigationSettings()
FIELD, OUTLINE = load_field("square", MAPS), RobotSpec.load().outline
FREE = FreeSpace.of(FIELD, OUTLINE, SETTINGS)
MARKS = FreeSpace.of(FIELD, OUTLINE, SETTINGS, Walls(tape="wall"), edge=False)


def across(distance: float) -> Scan:
    """Return a scan of a straight edge across the way, so far ahead [m]."""
    return Scan(0.0, BEARINGS, distance / np.cos(BEARINGS), sight=SIGHT)


@pytest.mark.parametrize("odom", [Pose2(), Pose2(0.3, -0.2, 2.0)])
def test_tape_stays_where_it_was_seen_when_the_robot_moves(odom):
    seen_at = odom @ Pose2(-0.1, 0.0, 0.0)
    points = tape_seen([Glimpse(seen_at, across(0.35))], odom)
    assert len(points) > 30
    assert points[:, 0] == pytest.approx(np.full(len(points), 0.25))


def test_a_speck_that_one_ray_sees_is_no_tape_and_two_beside_each_other_are():
    ranges = np.full(61, math.inf)
    ranges[[10, 30, 31]] = 0.3
    assert len(tape_in(Scan(0.0, BEARINGS, ranges, sight=SIGHT))) == 2


def test_tape_on_which_a_ray_begins_is_seen_where_it_begins_and_ends():
    hidden = np.tile([0.0, 0.2], (61, 1))
    scan = Scan(0.0, BEARINGS, np.full(61, math.inf), sight=SIGHT, hidden=hidden)
    away = np.hypot(*tape_in(scan).T)
    assert sorted({round(each, 3) for each in away.tolist()}) == [0.16, 0.2]


def test_a_ray_that_sees_nothing_sees_no_tape():
    scan = Scan(0.0, BEARINGS, np.full(61, 0.3), sight=np.full((61, 2), math.nan))
    assert len(tape_in(scan)) == 0


def test_no_move_comes_to_seen_tape_wherever_the_robot_may_be():
    places = np.zeros((4, 3))  # in the middle of the field, where nothing is in the way
    floor = ClearFloor.of([], Pose2())
    tape = tape_seen([Glimpse(Pose2(), across(0.3))], Pose2())
    ahead, back, left, *_ = sweeps_of(places, floor, FREE, tape)
    nose = FREE.hollow.body[:, 0].max()
    for amount in AHEAD:
        assert (ahead.risk(amount) == 1.0) == (nose + amount > 0.3 - SEEN_MARGIN_M - 0.003)
    assert back.risk(0.1) == left.risk(1.0) == 0.0
    assert sweeps_of(places, floor, FREE)[0].risk(0.3) == 0.0


@pytest.mark.parametrize("dares", [0, len(RISKS)])
@pytest.mark.parametrize("distance", [0.2, 0.3, 0.45])
def test_the_way_that_is_found_keeps_its_distance_however_much_is_dared(dares, distance):
    """Whatever the filter believes: here that it stands where no tape is near."""
    view = Glimpse(Pose2(), across(distance))
    move = look([view], Pose2(), MARKS, FREE, [Pose2()] * 3, dares=dares)
    tape = tape_in(view.scan)
    for leg in move.legs:
        assert steps_clear(leg.poses, move.rim, tape, 0.004) == len(leg.poses) - 1


def test_where_tape_is_ignored_the_robot_may_cross_it():
    free = FreeSpace.of(FIELD, OUTLINE, SETTINGS, Walls(tape="ignored"))
    view = Glimpse(Pose2(), across(0.2))
    move = look([view], Pose2(), MARKS, free, crosses_tape=True)
    assert move.legs
    assert len(move.rim) == 0
