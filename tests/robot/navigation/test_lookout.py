"""Looking around: moves that tell places apart, and at none of them come to tape."""

import math
from dataclasses import replace

import numpy as np
import pytest

from app.settings.config import MAPS
from robot.description.spec import RobotSpec
from robot.fields.field_loading import load_field
from robot.geometry import Pose2
from robot.navigation.free_space import FreeSpace
from robot.navigation.lookout import (
    AHEAD,
    FIRST,
    RISKS,
    SEES_M,
    TURNS,
    ClearFloor,
    look,
    only_place,
    seen_from,
    sweeps_of,
    told_apart,
)
from robot.navigation.possible_places import Glimpse, places_seen
from robot.navigation.settings import NavigationSettings
from robot.navigation.walls import Walls
from robot.scan import Scan

OUTLINE = RobotSpec.load().outline
BEARINGS = np.linspace(-0.5, 0.5, 61)
SIGHT = np.tile([SEES_M[0], SEES_M[1]], (61, 1))


def spaces(name):
    field = load_field(name, MAPS)
    settings = NavigationSettings()
    tape = Walls(tape="wall")
    return tuple(FreeSpace.of(field, OUTLINE, settings, tape, edge=edge) for edge in (False, True))


def view_of(marks, truth, odom=Pose2()):
    """Return what a robot sees at a true place; a ray that begins on tape is hidden there."""
    x, y, theta = truth.to_array()
    ranges, hidden = np.full(61, math.inf), np.tile([math.inf, -math.inf], (61, 1))
    for place, bearing in enumerate(BEARINGS):
        along = np.arange(*SEES_M, 0.002)
        heading = theta + bearing
        points = np.column_stack([x + along * np.cos(heading), y + along * np.sin(heading)])
        dark = marks.clearance(points) <= 0
        if dark[0]:
            light = np.flatnonzero(~dark)
            hidden[place] = 0.0, along[light[0]] if len(light) else SEES_M[1]
        elif dark.any():
            ranges[place] = along[dark.argmax()]
    return Glimpse(odom, Scan(0.0, BEARINGS, ranges, sight=SIGHT, hidden=hidden))


def free_pose(free, seed):
    rng = np.random.default_rng(seed)
    while True:
        x, y, theta = rng.uniform((-0.42, -0.42, -3.0), (0.42, 0.42, 3.0))
        if free.fits(np.array([[x, y, theta]])):
            return Pose2(float(x), float(y), float(theta))


def near(places, truth):
    off = places - truth.to_array()
    turned = np.abs((off[:, 2] + math.pi) % (2 * math.pi) - math.pi)
    return float(((np.hypot(off[:, 0], off[:, 1]) < 0.05) & (turned < 0.2)).mean())


@pytest.mark.parametrize("seed", range(3))
def test_the_true_place_is_among_those_that_agree_with_a_view(seed):
    marks, free = spaces("tee")
    truth = free_pose(free, seed)
    assert near(places_seen([view_of(marks, truth)], Pose2(), marks, free), truth) > 0.01


def test_views_along_a_way_leave_only_the_true_place_where_nothing_else_looks_so():
    marks, free = spaces("tee")
    truth = Pose2(-0.1, 0.1, 0.0)
    turns = [Pose2(0.0, 0.0, angle) for angle in (0.0, 0.9, 1.8, 2.7, -1.8, -0.9)]
    views = [view_of(marks, truth @ turned, turned) for turned in turns]
    assert near(places_seen(views, turns[-1], marks, free), truth @ turns[-1]) > 0.9


def test_tape_on_which_rays_begin_is_seen_too():
    """It has no range, and the floor behind it is not all that is seen."""
    marks, free = spaces("stub")
    truth = Pose2(-0.35, -0.36, -2.55)
    view = view_of(marks, truth)
    assert view.scan.hit.mean() < 0.2
    assert near(places_seen([view], Pose2(), marks, free), truth) > 0.03


@pytest.mark.parametrize("seed", range(4))
def test_the_outline_stays_clear_of_tape_on_the_moves_that_are_found(seed):
    marks, free = spaces("stub")
    truth = free_pose(free, seed)
    odom, views = Pose2(), []
    for _ in range(3):
        views.append(view_of(marks, truth @ odom, odom))
        move = look(views, odom, marks, free)
        assert move.reason
        for leg in move.legs:
            poses = [(truth @ Pose2.from_array(each)).to_array() for each in leg.poses]
            assert (free.room(np.array(poses)) > 0).all()
            odom = leg.end


def test_beside_tape_it_does_not_turn_its_tail_into_it():
    _, free = spaces("square")
    here = Pose2(0.0, -0.39, 0.0)
    places = np.tile(here.to_array(), (5, 1))
    nothing = ClearFloor.of([], Pose2())
    _, _, left, right, *_ = sweeps_of(places, nothing, free)
    assert left.risk(TURNS[-1]) == 1.0
    # To the right its tail turns away from the tape.
    assert left.risk(TURNS[0]) == right.risk(TURNS[-1]) == 0.0


def test_floor_that_was_seen_free_is_free_wherever_the_robot_is():
    marks, free = spaces("square")
    view = view_of(marks, Pose2(-0.3, 0.0, 0.0))
    floor = ClearFloor.of([view], Pose2())
    small = replace(free, body=0.2 * free.body)
    places = np.array([[0.25, 0.0, 0.0]])
    nothing = ClearFloor.of([], Pose2())
    assert sweeps_of(places, nothing, small)[0].risk(AHEAD[-1]) == 1.0
    # Its outline, which is small here, goes from before the camera's view onto seen floor.
    steps = np.array([[0.3, 0.0, 0.0], [0.3, 0.0, 1.0], [-0.1, 0.0, 0.0]])
    known = floor.has(steps, small.body)
    assert known[:2].all()
    assert not known[2].any()


def test_floor_behind_tape_or_behind_what_hides_it_was_not_seen():
    ranges = np.full(61, 0.4)
    scan = Scan(0.0, BEARINGS, ranges, sight=SIGHT)
    point = np.zeros((1, 2))
    poses = np.array([[0.3, 0.0, 0.0], [0.45, 0.0, 0.0], [0.1, 0.0, 0.0]])
    assert ClearFloor.of([Glimpse(Pose2(), scan)], Pose2()).has(poses, point).ravel().tolist() == [
        True,
        False,
        False,
    ]
    hidden = np.tile([0.2, 0.35], (61, 1))
    covered = Glimpse(Pose2(), replace(scan, hidden=hidden))
    assert not ClearFloor.of([covered], Pose2()).has(poses, point).any()


def test_it_does_not_look_again_where_it_has_looked():
    marks, free = spaces("square")
    truth = Pose2(0.0, 0.0, 0.3)
    views = [view_of(marks, truth)]
    move = look(views, Pose2(), marks, free)
    assert move.legs
    end = move.legs[-1].end
    views.insert(0, view_of(marks, truth @ end, end))
    assert not views[0].is_elsewhere(replace(views[0], odom_from_robot=end))
    again = look(views, Pose2(), marks, free)
    assert not again.legs or views[0].is_elsewhere(
        replace(views[0], odom_from_robot=again.legs[-1].end)
    )


def test_what_looks_alike_is_not_told_apart_and_what_does_not_is():
    marks, _ = spaces("square")
    turned = [Pose2(0.0, 0.0, part * math.pi / 2) @ Pose2(0.2, 0.1, 0.3) for part in range(4)]
    alike = np.array([each.to_array() for each in turned])
    assert told_apart(alike, seen_from(alike, marks)) < 0.01
    other = alike.copy()
    other[:2, 2] += 1.0
    assert told_apart(other, seen_from(other, marks)) > 0.2


def test_the_risk_of_a_move_is_the_share_of_places_where_it_comes_to_tape():
    _, free = spaces("square")
    places = np.array([[0.0, 0.0, 0.0], [0.38, 0.0, 0.0], [0.38, 0.0, math.pi], [0.0, 0.2, 1.0]])
    ahead = sweeps_of(places, ClearFloor.of([], Pose2()), free)[0]
    assert ahead.risk(0.1) == pytest.approx(0.25)
    assert ahead.risk(0.02) == 0.0


def test_where_it_has_stood_is_free_and_what_is_behind_it_is_not():
    _, free = spaces("square")
    rim = free.hollow.body
    floor = ClearFloor.of([], Pose2(), rim)
    inner = 0.8 * rim
    assert floor.has(np.zeros((1, 3)), inner).all()
    assert not floor.has(np.array([[-0.1, 0.0, 0.0]]), inner).all()


@pytest.mark.parametrize("level", range(len(RISKS)))
def test_however_much_is_dared_it_does_not_back_to_where_any_place_has_a_wall(level):
    _, free = spaces("square")
    # At one place of ten there is tape before its nose, at another one behind its tail.
    places = np.tile([0.0, 0.0, 0.0], (10, 1))
    places[0, 0], places[1, 0] = 0.34, -0.31
    ahead, back, left, *others = sweeps_of(places, ClearFloor.of([], Pose2()), free)
    assert ahead.risk(0.1) == back.risk(0.1) == 0.1
    assert ahead.allows(0.1, level) == left.allows(0.1, level) == (RISKS[level] >= 0.1)
    assert not back.allows(0.1, level)
    assert back.allows(0.0, level)
    assert [each.backs for each in others].count(True) == 2 * sum(each < 0 for each in FIRST)


@pytest.mark.parametrize("share", [0.96, 0.9])
def test_where_nearly_all_places_are_one_that_is_the_place(share):
    rng = np.random.default_rng(3)
    truth = np.array([0.37, -0.36, math.pi])
    places = truth + rng.normal(0, (0.01, 0.02, 0.05), (1000, 3))
    places[:, 2] = (places[:, 2] + math.pi) % (2 * math.pi) - math.pi
    places[round(1000 * share) :, :2] *= -1
    found = only_place(rng.permutation(places))
    if share < 0.95:
        assert found is None
        return
    assert found.pose.to_array()[:2] == pytest.approx(truth[:2], abs=0.003)
    assert abs(found.pose.turn_to(Pose2.from_array(truth))) < 0.01
    sd = np.sqrt(np.diag(found.covariance))
    assert sd == pytest.approx([0.014, 0.022, 0.058], rel=0.15)
