"""Looking around: moves that tell places apart, and at none of them come to tape."""

import math

import numpy as np
import pytest

from app.settings.config import MAPS
from robot.description.spec import RobotSpec
from robot.fields.field_loading import load_field
from robot.geometry import Pose2
from robot.navigation.free_space import FreeSpace
from robot.navigation.legs import straight
from robot.navigation.lookout import (
    SEES_M,
    Glimpse,
    look,
    places_seen,
    risk,
    seen_from,
    told_apart,
)
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


def view_of(marks, truth):
    """Return what a robot sees at a true place; its odometry begins there."""
    x, y, theta = truth.to_array()
    ranges = np.full(61, math.inf)
    for place, bearing in enumerate(BEARINGS):
        along = np.arange(*SEES_M, 0.002)
        heading = theta + bearing
        points = np.column_stack([x + along * np.cos(heading), y + along * np.sin(heading)])
        met = np.flatnonzero(marks.clearance(points) <= 0)
        if len(met):
            ranges[place] = along[met[0]]
    return Glimpse(Pose2(), Scan(0.0, BEARINGS, ranges, sight=SIGHT))


def free_pose(free, seed):
    rng = np.random.default_rng(seed)
    while True:
        x, y, theta = rng.uniform((-0.42, -0.42, -3.0), (0.42, 0.42, 3.0))
        if free.fits(np.array([[x, y, theta]])):
            return Pose2(float(x), float(y), float(theta))


@pytest.mark.parametrize("seed", range(3))
def test_places_that_agree_with_a_view_have_the_true_one_among_them(seed):
    marks, free = spaces("tee")
    truth = free_pose(free, seed)
    places = places_seen([view_of(marks, truth)], Pose2(), marks, free)
    off = places - truth.to_array()
    turned = np.abs((off[:, 2] + math.pi) % (2 * math.pi) - math.pi)
    assert ((np.hypot(off[:, 0], off[:, 1]) < 0.07) & (turned < 0.2)).any()


@pytest.mark.parametrize("seed", range(3))
def test_the_outline_stays_clear_of_tape_on_the_move_that_is_found(seed):
    marks, free = spaces("stub")
    truth = free_pose(free, seed)
    move = look([view_of(marks, truth)], Pose2(), marks, free)
    assert move.reason
    for leg in move.legs:
        poses = [(truth @ Pose2.from_array(each)).to_array() for each in leg.poses]
        assert (free.room(np.array(poses)) > 0).all()


def test_a_robot_that_stands_where_it_cannot_turn_does_not_turn():
    marks, free = spaces("square")
    here = Pose2(0.0, -0.42, 0.0)
    legs = look([view_of(marks, here)], Pose2(), marks, free, [here]).legs
    for leg in legs:
        poses = np.array([(here @ Pose2.from_array(each)).to_array() for each in leg.poses])
        assert free.room(poses).min() > 0


def test_what_looks_alike_is_not_told_apart_and_what_does_not_is():
    marks, _ = spaces("square")
    turned = [Pose2(0.0, 0.0, part * math.pi / 2) @ Pose2(0.2, 0.1, 0.3) for part in range(4)]
    alike = np.array([each.to_array() for each in turned])
    assert told_apart(seen_from(alike, marks)) < 0.01
    other = alike.copy()
    other[:2, 2] += 1.0
    assert told_apart(seen_from(other, marks)) > 0.5


def test_the_risk_of_a_move_is_the_share_of_places_where_it_comes_to_tape():
    _, free = spaces("square")
    places = np.array([[0.0, 0.0, 0.0], [0.4, 0.0, 0.0], [0.4, 0.0, math.pi], [0.0, 0.2, 1.0]])
    assert risk(places, Pose2(), (straight(Pose2(), 0.1),), free) == pytest.approx(0.25)
