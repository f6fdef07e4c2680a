"""From beside walls to where the robot may turn: it comes nearer to no wall on the way."""

import numpy as np
import pytest

from app.settings.config import MAPS
from robot.description.spec import RobotSpec
from robot.fields.field_loading import load_field
from robot.geometry import Pose2
from robot.navigation.free_space import FreeSpace
from robot.navigation.gates import SAME_ROOM, gate
from robot.navigation.settings import NavigationSettings


def space(name: str) -> FreeSpace:
    outline = RobotSpec.load().outline
    return FreeSpace.of(load_field(name, MAPS), outline, NavigationSettings())


def tight_places(free: FreeSpace, count: int, seed: int) -> list[Pose2]:
    """Return poses where the robot fits, and cannot turn all around."""
    rng = np.random.default_rng(seed)
    low, high = np.array(free.drive_area).reshape(2, 2)
    found = []
    while len(found) < count:
        pose = Pose2(*rng.uniform(low, high), rng.uniform(-np.pi, np.pi))
        if free.fits(pose.to_array()[None]) and not free.turns(pose.to_array()[None, :2]):
            found.append(pose)
    return found


@pytest.mark.parametrize("away", [True, False])
@pytest.mark.parametrize(("name", "out"), [("stub", 60), ("town", 55), ("generated-9102", 60)])
def test_nearly_each_place_has_a_way_that_keeps_its_room(name, out, away):
    free, found = space(name), 0
    for pose in tight_places(free, 60, 3):
        way = gate(free, pose, away=away)
        if way is None:
            continue
        found += 1
        legs, other = way
        assert free.turns(other.to_array()[None, :2])
        begin, end = (pose, other) if away else (other, pose)
        here = begin
        for leg in legs:
            assert here.distance_to(Pose2.from_array(leg.poses[0])) < 1e-9
            assert abs(here.turn_to(Pose2.from_array(leg.poses[0]))) < 1e-9
            here = leg.end
            ahead = here.to_array()[:2] - leg.poses[0, :2]
            heading = leg.poses[0, 2]
            along = ahead @ (np.cos(heading), np.sin(heading))
            assert leg.on_spot or (along < 0) == leg.backwards
        assert here.distance_to(end) < 1e-9
        assert abs(here.turn_to(end)) < 1e-9
        kept = free.settings.clearance - SAME_ROOM
        assert all(free.room(leg.poses).min() > kept for leg in legs)
    assert found >= out


def test_where_a_robot_has_turned_to_it_gets_away_from():
    """It had looked around beside tee's bar, and was told to be driven away by hand."""
    free = space("tee")
    way = gate(free, Pose2(0.349, 0.310, -3.04), away=True)
    assert way is not None
    assert free.turns(way[1].to_array()[None, :2])


def test_it_goes_to_and_fro_out_of_a_narrow_gap():
    free = space("tee")
    legs, _ = gate(free, Pose2(0.36, -0.16, -2.44), away=True)
    assert len(legs) == 4


def test_a_robot_that_stands_in_a_wall_leaves_it_and_comes_into_none_again():
    free = space("square")
    pose = Pose2(0.44, 0.0, 0.0)
    assert free.room(pose.to_array()[None])[0] <= 0
    legs, other = gate(free, pose, away=True)
    assert free.turns(other.to_array()[None, :2])
    rooms = np.concatenate([free.room(leg.poses) for leg in legs]) > 0
    assert (rooms[1:] >= rooms[:-1]).all()
