"""Legs with their times: within the limits, and consistent with themselves."""

import math

import numpy as np
import pytest

from robot.geometry import Pose2
from robot.navigation.legs import curve, rounded, straight, turn
from robot.navigation.timed_way import Limits, timed

LIMITS = Limits(0.2, 0.48, 0.5, 1.8, 3.2, 0.33, 0.056)
CORNERS = np.array([[0.0, 0.0], [0.5, 0.0], [0.5, 0.5], [0.1, 0.7]])


def a_way():
    way = curve(rounded(CORNERS, 0.1))
    return turn(Pose2(0, 0, 1.0), 0.0), way, turn(way.end, 0.3)


def test_a_rounded_path_begins_and_ends_where_its_corners_do_and_bends_evenly():
    leg = curve(rounded(CORNERS, 0.1))
    assert leg.poses[0, :2] == pytest.approx(CORNERS[0], abs=1e-12)
    assert leg.poses[-1, :2] == pytest.approx(CORNERS[-1], abs=1e-12)
    bend = np.gradient(leg.poses[:, 2]) / 0.005
    assert np.abs(bend).max() < 25
    assert np.abs(np.diff(bend)).max() < 4


def test_speeds_and_their_changes_keep_the_limits():
    trajectory = timed(a_way(), LIMITS)
    v, omega = trajectory.twists.T
    steps = np.diff(trajectory.times)
    assert np.abs(v).max() <= LIMITS.speed + 1e-9
    assert np.abs(omega).max() <= LIMITS.turning * 1.02
    assert (np.abs(v) + LIMITS.half_track * np.abs(omega)).max() <= LIMITS.rim + 1e-9
    gain, loss = np.diff(v) / steps, -np.diff(v) / steps
    assert gain.max() <= LIMITS.gain * 1.05
    assert loss.max() <= LIMITS.loss * 1.05


def test_the_velocity_is_that_of_the_poses():
    trajectory = timed(a_way(), LIMITS)
    time = np.arange(0.0, trajectory.duration, 0.01)
    poses = np.array([trajectory.at(t).pose.to_array() for t in time])
    way = np.hypot(*np.diff(poses[:, :2], axis=0).T) / 0.01
    v = np.array([trajectory.at(t + 0.005).twist.v for t in time[:-1]])
    assert way == pytest.approx(v, abs=0.012)
    turned = np.diff(np.unwrap(poses[:, 2])) / 0.01
    omega = np.array([trajectory.at(t + 0.005).twist.omega for t in time[:-1]])
    assert np.abs(turned - omega).max() < 0.35
    assert np.abs(turned - omega).mean() < 0.03


def test_what_is_left_falls_to_nothing():
    legs = a_way()
    trajectory = timed(legs, LIMITS)
    assert trajectory.left_at(0) == pytest.approx(sum(leg.length for leg in legs), abs=0.01)
    left = [trajectory.left_at(t) for t in np.linspace(0, trajectory.duration, 99)]
    assert (np.diff(left) <= 1e-12).all()
    assert left[-1] == 0
    assert trajectory.at(-1.0).pose == trajectory.at(0.0).pose
    assert trajectory.at(1e9).pose == trajectory.at(trajectory.duration).pose
    assert trajectory.goal.distance_to(legs[-1].end) < 1e-12


@pytest.mark.parametrize("distance", [0.0006, 0.004, 0.08, -0.3, 1.2])
def test_a_straight_way_of_any_length_takes_as_long_as_it_must(distance):
    trajectory = timed((straight(Pose2(0.1, 0.2, 0.3), distance),), LIMITS)
    way = abs(distance)
    ramps = LIMITS.speed**2 / 2 * (1 / LIMITS.gain + 1 / LIMITS.loss)
    if way > ramps:
        ideal = (way - ramps) / LIMITS.speed + LIMITS.speed * (1 / LIMITS.gain + 1 / LIMITS.loss)
    else:
        peak = math.sqrt(2 * way / (1 / LIMITS.gain + 1 / LIMITS.loss))
        ideal = peak * (1 / LIMITS.gain + 1 / LIMITS.loss)
    assert ideal - 1e-9 <= trajectory.duration < 1.35 * ideal + 0.02
    assert trajectory.twists[:, 0].min() >= min(0.0, math.copysign(0.2, distance)) - 1e-9
    end = Pose2(0.1, 0.2, 0.3) @ Pose2(distance)
    assert trajectory.goal.distance_to(end) < 1e-9


@pytest.mark.parametrize("angle", [0.003, -0.4, 3.0])
def test_a_turn_on_the_spot_is_a_trapezoid(angle):
    trajectory = timed((turn(Pose2(0.1, 0.2, 0.5), 0.5 + angle),), LIMITS)
    end = trajectory.at(trajectory.duration).pose
    assert end.x == pytest.approx(0.1)
    assert end.turn_to(Pose2(0.1, 0.2, 0.5 + angle)) == pytest.approx(0.0, abs=1e-9)
    assert np.abs(trajectory.twists[:, 1]).max() <= LIMITS.turning + 1e-9
