"""A belief that does not explain the scans gets a rival."""

from dataclasses import replace

import numpy as np
import pytest
from laser_office import LASER, START, office_map, true_pose

from app.features.lab.localize.localize import GivenStart, localize
from app.features.lab.localize.reading.pairing import Measurement
from app.features.lab.localize.settings import LocalizeSettings
from benchmarks.lasers.laser_robot import measurements, wander
from robot.geometry import Pose2

ELSEWHERE = Pose2(8.5, 2.0, 1.5)
SECONDS = 30.0


@pytest.fixture(scope="module")
def drives():
    on = office_map()
    return tuple(tuple(wander(on, LASER, SECONDS, 4, at)) for at in (START, ELSEWHERE))


def off(one, truth):
    """Distance of what was told from the truth [m]."""
    there = truth[one.stamp]
    return np.hypot(one.pose[0] - there.x, one.pose[1] - there.y)


def end_of(found):
    return Pose2.from_array(found.poses[-1])


def test_a_robot_that_was_told_to_be_elsewhere_is_found(drives):
    on, seen = office_map(), drives[0]
    wrong = GivenStart(on.pose_in_map(ELSEWHERE), 0.3, 0.2)
    found = localize(measurements(iter(seen), LASER), on, LocalizeSettings(), wrong, 0)
    assert found.places_left == 1
    assert end_of(found).distance_to(true_pose(seen[-1])) < 0.15
    truth = {one.stamp: true_pose(one) for one in seen}
    assert found.withdrawn
    assert all(off(one, truth) > 1 for one in found.withdrawn)
    assert max(off(one, truth) for one in found.standing) < 0.3
    assert {one.leader for one in found.withdrawn} == {0}
    assert {one.leader for one in found.standing} == {1}


def test_a_robot_that_is_carried_to_another_room_is_found_again(drives):
    on, (first, second) = office_map(), drives
    went = first[-1].odometry
    carried = [
        Measurement(went @ one.odom_from_robot, _later(one.scan))
        for one in measurements(iter(second), LASER)
    ]
    both = [*measurements(iter(first), LASER), *carried]
    start = GivenStart(on.pose_in_map(START), 0.3, 0.2)
    found = localize(both, on, LocalizeSettings(), start, 0)
    truth = {one.stamp: true_pose(one) for one in first}
    truth |= {round(SECONDS + one.stamp, 6): true_pose(one) for one in second}
    before = [one for one in found.standing if one.stamp < SECONDS]
    # Right as it was, what was told just before it was carried is withdrawn with the rest.
    assert before[-1].stamp > SECONDS - 6
    assert len(before) > 0.8 * len(first)
    assert max(off(one, truth) for one in found.standing) < 0.3
    assert max(off(one, truth) for one in found.withdrawn) > 1
    assert end_of(found).distance_to(true_pose(second[-1])) < 0.15


def test_a_robot_whose_place_explains_what_it_sees_gets_no_rival(drives):
    on, seen = office_map(), drives[0]
    start = GivenStart(on.pose_in_map(START), 0.3, 0.2)
    found = localize(measurements(iter(seen), LASER), on, LocalizeSettings(), start, 0)
    assert found.places_left == 0
    assert len(found.poses) == len(seen)


def _later(scan):
    return replace(scan, stamp=round(SECONDS + scan.stamp, 6))
