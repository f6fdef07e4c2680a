"""Millimetres for metres, and degrees for radians, are named."""

import math
import re

import numpy as np
import pytest
from laser_office import BEGAN, LASER, drive, office_map, write_map
from paired_bags import paired

from app.command_line import main
from app.features.lab.localize.reading.sources import BagError
from app.features.lab.localize.reading.units import UnitEvidence, require_metres
from benchmarks.lasers.laser_bags import LaserBag
from robot.geometry import Pose2


def write(path, lengths=1.0, way=1.0, angles=1.0):
    with LaserBag(path, "mcap") as bag:
        bag.transform(BEGAN, "base_link", "laser", LASER.place, topic="/tf_static")
        for each in drive():
            pose = each.odometry
            bag.odometry(BEGAN + each.stamp, Pose2(way * pose.x, way * pose.y, pose.theta))
            form = {"first": angles * LASER.bearings[0], "step": angles * LASER.step}
            reach = (0.05 * lengths, LASER.reach * lengths)
            bag.scan(BEGAN + each.stamp, lengths * np.asarray(each.ranges), reach=reach, **form)
    return path


@pytest.mark.parametrize(
    ("units", "words"),
    [
        ({"lengths": 1000.0}, r"ranges of about .* the map is 14.4 m across; as millimetres they"),
        ({"lengths": 100.0}, r"ranges of about .* as centimetres they would fit"),
        ({"way": 1000.0}, r"odometry usually drives at .* in millimetres it would fit"),
        ({"angles": math.degrees(1)}, r"angles of scans span 35\d.*as degrees they would fit"),
        ({"lengths": 1000.0, "way": 1000.0}, r"as millimetres they would fit"),
    ],
)
def test_another_unit_is_named(tmp_path, capsys, units, words):
    path = write(tmp_path / "bag", **units)
    options = ["--map", str(write_map(tmp_path)), "--out", str(tmp_path / "out")]
    assert main(["localize", str(path), *options]) == 1
    assert pytest.approx(14.4, abs=0.1) == office_map().across
    assert re.search(words, capsys.readouterr().err)


def test_a_map_that_is_drawn_names_the_unit_too(tmp_path):
    with pytest.raises(BagError, match="as millimetres"):
        paired(write(tmp_path / "bag", lengths=1000.0))


def test_metres_and_radians_are_no_other_unit(tmp_path):
    assert len(paired(write(tmp_path / "bag"))[0]) == len(drive())
    empty = UnitEvidence(math.nan, 0.0)
    require_metres([], np.zeros(0), [], None)
    require_metres(
        [empty, UnitEvidence(250.0, 2 * math.pi)], np.arange(2.0), [Pose2(), Pose2(1.0)], None
    )
    fast = [Pose2(2.0 * tick) for tick in range(100)]
    require_metres([empty], np.arange(100) / 10, fast, 5.0)
