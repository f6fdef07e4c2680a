"""Closed curves: they end where they begin, and come again without a jump."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robot.geometry import Pose2, wrap_angle
from robot.navigation.curves import ClosedCurve, CurveError, Lap, lap_of
from robot.navigation.timed_way import Limits, timed_loop

LIMITS = Limits(0.15, 0.48, 0.5, 2.1, 6.4, 0.33, 0.056)
START = Pose2(0.1, -0.2, 0.7)
POINTS = ((0.2, 0.2), (-0.2, 0.25), (-0.25, -0.2), (0.25, -0.25))


def lap(shape: str, size: float = 0.19, start: Pose2 = START) -> Lap:
    points = POINTS if shape == "points" else ()
    return lap_of(ClosedCurve(shape, size, points), start, LIMITS)


@pytest.mark.parametrize("shape", ["figure_eight", "circle", "square", "points"])
def test_a_lap_ends_where_it_begins(shape):
    poses = lap(shape).poses
    assert np.allclose(poses[-1, :2], poses[0, :2], atol=1e-9)
    assert abs(wrap_angle(poses[-1, 2] - poses[0, 2])) < 1e-6


@given(
    radius=st.floats(0.05, 2.0),
    start=st.builds(Pose2, st.floats(-1, 1), st.floats(-1, 1), st.floats(-3, 3)),
)
def test_a_circle_has_its_radius_everywhere(radius, start):
    points = lap("circle", radius, start).poses[:, :2]
    middle = start.apply(np.array([[0.0, radius]]))
    assert np.allclose(np.hypot(*(points - middle).T), radius, atol=1e-9)


def test_a_figure_eight_is_two_circles_to_half_a_millimetre():
    points = START.inverse().apply(lap("figure_eight").poses[:, :2])
    left, right = (np.abs(np.hypot(*(points - (0, y)).T) - 0.19) for y in (0.19, -0.19))
    assert np.minimum(left, right).max() < 0.0005
    assert points[len(points) // 4, 1] > 0.3
    assert points[3 * len(points) // 4, 1] < -0.3


def test_a_curve_by_points_leads_through_them():
    points = lap("points").poses[:, :2]
    for x, y in POINTS:
        assert np.hypot(points[:, 0] - x, points[:, 1] - y).min() < 0.003


@pytest.mark.parametrize("shape", ["figure_eight", "circle", "square", "points"])
def test_it_comes_again_without_a_jump_and_keeps_its_limits(shape):
    way = timed_loop(lap(shape).legs, LIMITS)
    begin, end = way.loop
    assert way.duration == math.inf
    for time in np.arange(0.0, end + 2 * (end - begin), 0.01):
        now, then = way.at(time), way.at(time + 0.01)
        assert now.pose.distance_to(then.pose) < 0.15 * 0.01 + 1e-4
        assert abs(then.twist.omega - now.twist.omega) < 0.12
        assert abs(now.twist.v) <= 0.15 + 1e-9
    later = end + 3.3 * (end - begin)
    assert way.at(later).pose.distance_to(way.at(later - (end - begin)).pose) < 1e-6
    assert 0 <= way.left_at(later) <= way.left[0]
    assert 0 <= way.time_left(later) <= end - begin


@pytest.mark.parametrize("shape", ["figure_eight", "circle", "square", "points"])
def test_it_may_begin_anywhere_on_the_lap(shape):
    whole = lap(shape)
    place = Pose2.from_array(whole.poses[len(whole.poses) // 3])
    begun = whole.begun_near(place)
    assert begun.begin.distance_to(place) < 0.4 if shape == "square" else 1e-9
    assert np.allclose(begun.poses[-1, :2], begun.poses[0, :2], atol=1e-9)
    assert len(begun.poses) == len(whole.poses)
    assert np.abs(np.diff(begun.poses[:, 2])).max() < 0.2 or shape == "square"


@pytest.mark.parametrize(
    ("points", "words"),
    [
        ((), "points are given with the shape points"),
        (POINTS[:2], "2 points; valid are 3 or more"),
        ((*POINTS, POINTS[0]), "0.0 mm apart; valid is 5 mm"),
    ],
)
def test_what_is_no_curve_is_refused(points, words):
    with pytest.raises(CurveError, match=words):
        ClosedCurve("points", 0.19, points)
