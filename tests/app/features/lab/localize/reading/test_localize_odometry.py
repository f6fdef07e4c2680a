"""Odometry to which no robot can have driven: left out, counted, and without cost for the rest."""

import math

import numpy as np
import pytest
from laser_office import BEGAN, LASER, drive, write_map

from app.command_line import main
from app.features.lab.localize.reading.odometry import OdometryTrack
from benchmarks.lasers.laser_bags import LaserBag
from robot.geometry import Pose2

RATE = 20.0
COUNT = 200


def way(speed=0.5, turn=0.3):
    """Poses of an arc, at 20 Hz."""
    stamps = [tick / RATE for tick in range(COUNT)]
    poses = [
        Pose2(speed / turn * math.sin(turn * t), speed / turn * (1 - math.cos(turn * t)), turn * t)
        for t in stamps
    ]
    return stamps, poses


@pytest.mark.parametrize("place", [0, 1, 2, 7, 100, COUNT - 2, COUNT - 1])
@pytest.mark.parametrize(
    "absurd",
    [
        Pose2(1e200, 0.0), Pose2(0.0, -1e256), Pose2(1.0001644035443793e256, 4.7e-54),
        Pose2(1e5, 3.0), Pose2(1e12, 1e12), Pose2(-40.0, 0.0), Pose2(0.0, 1e308, 2.0),
    ],
)  # fmt: skip
def test_one_absurd_pose_is_left_out_and_the_others_are_as_they_were(place, absurd):
    stamps, poses = way()
    track = OdometryTrack.of(stamps, [*poses[:place], absurd, *poses[place + 1 :]])
    assert track.absurd == 1
    assert track.jumps == ()
    assert track.poses == [*poses[:place], *poses[place + 1 :]]


def test_a_heading_that_is_turned_once_is_left_out():
    stamps, poses = way()
    turned = Pose2(poses[50].x, poses[50].y, poses[50].theta + math.pi)
    track = OdometryTrack.of(stamps, [*poses[:50], turned, *poses[51:]])
    assert (track.absurd, len(track.poses)) == (1, COUNT - 1)


@pytest.mark.parametrize("share", [0.05, 0.2])
def test_many_spikes_are_left_out(share):
    rng = np.random.default_rng(4)
    stamps, poses = way()
    hit = rng.random(COUNT) < share
    given = [
        Pose2(*rng.normal(0, 1e5, 2), pose.theta) if bad else pose
        for pose, bad in zip(poses, hit, strict=True)
    ]
    track = OdometryTrack.of(stamps, given)
    assert track.poses == [pose for pose, bad in zip(poses, hit, strict=True) if not bad]


def test_odometry_that_begins_anew_is_followed_on_and_told():
    stamps, poses = way()
    back = poses[120].inverse()
    track = OdometryTrack.of(stamps, [*poses[:120], *(back @ pose for pose in poses[120:])])
    assert track.absurd == 0
    ((moment, metres),) = track.jumps
    assert moment == stamps[120]
    assert metres == pytest.approx(math.hypot(poses[119].x, poses[119].y), abs=0.05)
    assert track.poses[-1].distance_to(poses[-1]) < 0.05  # one interval is not known


def test_a_fast_car_that_stands_half_of_the_time_is_not_absurd():
    stamps = [tick / RATE for tick in range(COUNT)]
    xs = np.cumsum([20.0 / RATE if tick > COUNT / 2 else 0.0 for tick in range(COUNT)])
    track = OdometryTrack.of(stamps, [Pose2(x) for x in xs])
    assert (track.absurd, track.jumps, len(track.poses)) == (0, (), COUNT)


def test_a_way_without_a_pose_or_with_one_is_a_track():
    assert OdometryTrack.of([], []).at(1.0) is None
    assert OdometryTrack.of([1.0], [Pose2(2.0)]).at(1.0) == Pose2(2.0)
    assert OdometryTrack.of([1.0, 1.1], [Pose2(1e300), Pose2(1e300)]).at(1.0) is None


@pytest.mark.slow
@pytest.mark.parametrize("command", ["localize", "map"])
@pytest.mark.parametrize(("every", "first"), [(None, 10), (25, 0)])
def test_absurd_odometry_ends_no_command_and_is_told(tmp_path, capsys, command, every, first):
    path = tmp_path / "drive"
    seen = drive()
    bad = [tick < first or (every and tick % every == 7) for tick in range(len(seen))]
    with LaserBag(path, "mcap") as bag:
        bag.transform(BEGAN, "base_link", "laser", LASER.place, topic="/tf_static")
        for each, wrong in zip(seen, bad, strict=True):
            stamp = BEGAN + each.stamp
            bag.odometry(stamp, Pose2(1e200, -1e256) if wrong else each.odometry)
            bag.scan(stamp, each.ranges, first=LASER.bearings[0], step=LASER.step)
    options = (
        ["--map", str(write_map(tmp_path)), "--out", str(tmp_path / "out")]
        if command == "localize"
        else ["--out", str(tmp_path / "drawn.yaml")]
    )
    assert main([command, str(path), *options]) == 0
    words = f"{sum(map(bool, bad))} odometry messages with places to which no robot can drive"
    assert words in capsys.readouterr().out
