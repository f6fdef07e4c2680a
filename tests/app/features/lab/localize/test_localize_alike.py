"""Two rooms that look alike: nothing is told before the scans decide between them."""

import math

import numpy as np
import pytest

from app.features.lab.localize.laser_map import LaserMap
from app.features.lab.localize.localize import localize
from app.features.lab.localize.localized import Localized, ReportedPose
from app.features.lab.localize.settings import LocalizeSettings
from benchmarks.lasers.laser_robot import Laser, measurements, wander
from robot.fields.occupancy_grid import OccupancyGrid
from robot.geometry import Pose2
from robot.localization.estimate import State

LASER = Laser(beams=180, reach=3.5, place=Pose2())
LENGTH, WIDTH, THICK = 240, 60, 4
"""Of a room and of walls, in cells of 5 cm."""
START = Pose2(1.5, 1.6, 0.0)
BOX_FROM = 9.0
"""[m] along the room; only one of the two has that box."""
SEEN_FROM = BOX_FROM - LASER.reach
"""The robot cannot see the box before it is here [m]."""


def twins(*, alike):
    """One room above the other, with the same things in them, but for the box."""
    cells = np.full((2 * WIDTH + 40, LENGTH + 20), -1, dtype=np.int8)
    for bottom in (10, WIDTH + 30):
        cells[bottom : bottom + WIDTH, 10 : 10 + LENGTH] = 100
        cells[bottom + THICK : bottom + WIDTH - THICK, 10 + THICK : 10 + LENGTH - THICK] = 0
        for along in (50, 110, 160):
            cells[bottom + WIDTH - 14 : bottom + WIDTH - THICK, along : along + 8] = 100
        cells[bottom + THICK : bottom + 12, 75:85] = 100
    if not alike:
        at = round(BOX_FROM / 0.05)
        cells[10 + THICK : 30, at : at + 12] = 100
    return LaserMap.of(OccupancyGrid(cells, 0.05, Pose2()), "twins")


def followed(on, seconds, seed):
    seen = tuple(wander(on, LASER, seconds, 3, START))
    return seen, localize(measurements(iter(seen), LASER), on, LocalizeSettings(), None, seed)


@pytest.mark.parametrize("seed", range(3))
def test_in_one_of_two_rooms_that_are_the_same_nothing_is_told(seed):
    _, found = followed(twins(alike=True), 25.0, seed)
    assert not found.reports
    assert found.state is not State.CERTAIN
    assert not found.states[State.CERTAIN]


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3))
def test_once_the_box_decides_the_room_is_told_and_not_before(seed):
    seen, found = followed(twins(alike=False), 40.0, seed)
    decided = next(one.stamp for one in seen if one.truth.x > SEEN_FROM)
    assert found.reports, found.states
    assert found.reports[0].stamp > decided
    truth = {one.stamp: one.truth for one in seen}
    off = [
        math.hypot(one.pose[0] - truth[one.stamp].x, one.pose[1] - truth[one.stamp].y)
        for one in found.reports
    ]
    assert max(off) < 0.3
    assert found.known


def told(stamp, leader=0, *, withdrawn=True):
    return ReportedPose(stamp, np.zeros(3), np.zeros(3), leader, withdrawn)


def test_what_was_withdrawn_is_told_by_spans():
    found = Localized(
        reports=[
            told(0.0, withdrawn=False), told(0.5), told(1.0), told(1.5),
            told(5.0), told(5.5, leader=1), told(6.0, leader=1), told(6.5, 2, withdrawn=False),
        ]
    )  # fmt: skip
    assert found.spans() == [(0.5, 1.5, 0), (5.0, 5.0, 0), (5.5, 6.0, 1)]
    assert found.withdrawn_s == pytest.approx(1.5)
    assert found.stamps == [0.0, 6.5]
