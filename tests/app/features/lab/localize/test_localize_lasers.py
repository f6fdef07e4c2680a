"""A robot with two lasers: both are used, each from where it sits."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest
from laser_office import BEGAN, drive, office_map, true_pose, write_map

from app.command_line import main
from app.features.lab.trajectories.reading import parse_tum
from benchmarks.lasers.laser_bags import LaserBag
from benchmarks.lasers.laser_robot import Laser
from robot.fields.grid_map import load_map_yaml
from robot.fields.ray_casting import cast_rays
from robot.geometry import Pose2, interpolate

pytestmark = pytest.mark.slow

FRONT = Laser(beams=91, view=math.radians(90), reach=4.0, place=Pose2(0.3, 0.1, 0.2))
REAR = replace(FRONT, beams=61, place=Pose2(-0.3, -0.1, math.pi + 0.3))
SECONDS = 20.0


def rear_ranges(pose, rng):
    """What the laser at the back sees (beams,) from a pose of the robot in the cells' frame."""
    exact = np.empty((1, REAR.beams))
    place = (pose @ REAR.place).to_array()[None]
    cast_rays(place, REAR.bearings, office_map().field.edge_index, REAR.reach, exact)
    return exact[0] + rng.normal(0, REAR.sd, REAR.beams)


def write(path, later=0.0, mounted=True):
    """A bag whose second laser scans so much later than the first [s]."""
    seen, rng = drive(FRONT, SECONDS), np.random.default_rng(7)
    with LaserBag(path, "mcap") as bag:
        if mounted:
            for name, laser in (("front", FRONT), ("rear", REAR)):
                bag.transform(BEGAN, "base_link", name, laser.place, topic="/tf_static")
        for one, following in zip(seen, [*seen[1:], seen[-1]], strict=True):
            stamp = BEGAN + one.stamp
            bag.odometry(stamp, one.odometry)
            form = {"step": FRONT.step, "reach": (0.05, FRONT.reach)}
            bag.scan(
                stamp, one.ranges, first=FRONT.bearings[0], frame="front", topic="/front", **form
            )
            pose = interpolate(one.truth, following.truth, 10 * later)
            form["step"] = REAR.step
            bag.scan(
                stamp + later, rear_ranges(pose, rng),
                first=REAR.bearings[0], frame="rear", topic="/rear", **form,
            )  # fmt: skip
    return path


BOTH = ("--scan-topic", "/front", "--scan-topic", "rear")


def localized(folder, bag, *options):
    out = folder / "out"
    given = ("localize", str(bag), "--map", str(write_map(folder)), "--out", str(out))
    assert main([*given, *options]) == 0
    way = parse_tum((out / "localized.tum").read_text(), "localized.tum")
    return json.loads((out / "results.json").read_text()), way


def off(way):
    """Distance [m] of each pose from the truth, between whose stamps it may lie."""
    seen = drive(FRONT, SECONDS)
    poses = np.array([true_pose(one).to_array()[:2] for one in seen])
    stamps = [BEGAN + one.stamp for one in seen]
    true = np.column_stack([np.interp(way.stamps, stamps, side) for side in poses.T])
    return np.hypot(*(way.poses[:, :2] - true).T)


@pytest.mark.parametrize("later", [0.0, 0.04])
def test_two_lasers_find_the_robot_sooner_than_one(tmp_path, later, capsys):
    bag = write(tmp_path / "two", later)
    both, way = localized(tmp_path, bag, *BOTH)
    told = capsys.readouterr().out
    assert "/front and /odom, laser as told by the transform base_link to front" in told
    assert "/rear and /odom, laser as told by the transform base_link to rear" in told
    assert both["scans"]["used"] >= 2 * len(drive(FRONT, SECONDS)) - 1
    assert both["known"] and off(way)[-40:].max() < 0.1
    assert np.median(off(way)) < 0.04
    alone, _ = localized(tmp_path, bag, "--scan-topic", "/front")
    assert 1.5 < both["rates"]["updates"] / alone["rates"]["updates"] < 2.1
    assert both["known_from"] <= (alone["known_from"] or math.inf)
    assert [laser["scan"] for laser in both["lasers"]] == ["/front", "/rear"]
    assert both["lasers"][1]["base_from_laser"]["translation"][0] == pytest.approx(-0.3)
    assert "lasers" not in alone


def test_lasers_without_transforms_are_placed_by_hand_in_their_order(tmp_path, capsys):
    bag = write(tmp_path / "two", mounted=False)
    poses = [
        ["--laser-pose", *map(str, laser.place.to_array().tolist())] for laser in (FRONT, REAR)
    ]
    _, way = localized(tmp_path, bag, *BOTH, *poses[0], *poses[1])
    assert off(way)[-40:].max() < 0.1
    given = ["localize", str(bag), "--map", str(write_map(tmp_path)), *BOTH]
    assert main([*given, *poses[0]]) == 2
    assert "--laser-pose is there 1 times; valid is once for each laser (2)" in (
        capsys.readouterr().err
    )
    assert main([*given, "--scan-topic", "/front"]) == 2
    assert "--scan-topic names a topic twice" in capsys.readouterr().err


def test_walls_that_only_the_laser_at_the_back_sees_are_mapped(tmp_path):
    bag = write(tmp_path / "two")
    cells = {}
    for name, topics in (("both", BOTH), ("front", BOTH[:2])):
        out = tmp_path / f"{name}.yaml"
        assert main(["map", str(bag), "--method", "graph", *topics, "--out", str(out)]) == 0
        cells[name] = int(np.count_nonzero(load_map_yaml(out).occupied))
    assert cells["both"] > 1.2 * cells["front"]
