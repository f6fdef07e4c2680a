"""Poses are a group, angles stay in [-pi, pi), and a twist integrates to an arc."""

from __future__ import annotations

import math
import sys

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robot.geometry import (
    Pose2,
    Twist2,
    compose,
    heading_angles,
    heading_vectors,
    interpolate,
    mean_pose,
    pose_covariance,
    wrap_angle,
)

lengths = st.floats(-50, 50)
turns = st.floats(-20, 20)
poses = st.builds(Pose2, lengths, lengths, turns)
anything = st.floats(allow_nan=False, allow_infinity=False)
EDGES = [
    0.0,
    -0.0,
    math.pi,
    -math.pi,
    math.nextafter(math.pi, 0),
    math.nextafter(math.pi, 4),
    math.nextafter(-math.pi, 0),
    math.nextafter(-math.pi, -4),
    -sys.float_info.min,
    -5e-324,
    -1e-17,
    3 * math.pi,
    -3 * math.pi,
    1e16,
    -1e300,
    sys.float_info.max,
]


def same(one: Pose2, other: Pose2, tolerance: float = 1e-9) -> bool:
    return one.distance_to(other) < tolerance and abs(one.turn_to(other)) < tolerance


@pytest.mark.parametrize("angle", EDGES)
def test_an_angle_at_an_edge_is_wrapped_into_the_half_open_turn(angle: float) -> None:
    assert -math.pi <= wrap_angle(angle) < math.pi
    wrapped = wrap_angle(np.array([angle]))
    assert -math.pi <= wrapped[0] < math.pi
    assert wrapped[0] == wrap_angle(angle), "one formula for numbers and arrays"


@given(anything)
def test_any_angle_is_wrapped_into_the_half_open_turn(angle: float) -> None:
    assert -math.pi <= wrap_angle(angle) < math.pi
    assert -math.pi <= Pose2(0, 0, angle).theta < math.pi


@given(st.floats(-1e4, 1e4))
def test_wrapping_changes_an_angle_by_full_turns_only(angle: float) -> None:
    full = (angle - wrap_angle(angle)) / (2 * math.pi)
    assert full == pytest.approx(round(full), abs=1e-9)
    assert wrap_angle(wrap_angle(angle)) == pytest.approx(wrap_angle(angle), abs=1e-12)


def test_half_a_turn_is_minus_pi_either_way() -> None:
    assert wrap_angle(math.pi) == wrap_angle(-math.pi) == -math.pi


@pytest.mark.parametrize("odd", [math.nan, math.inf, -math.inf])
def test_what_is_no_angle_becomes_none(odd: float) -> None:
    assert math.isnan(wrap_angle(odd))
    assert not Pose2(0, 0, odd).is_finite()


@pytest.mark.parametrize("pose", [Pose2(math.nan), Pose2(0, math.inf), Pose2(0, 0, math.nan)])
def test_a_pose_with_one_odd_number_is_not_finite(pose: Pose2) -> None:
    assert not pose.is_finite()
    assert Pose2(1e300, -1e300, 3).is_finite()


@given(poses, poses, poses)
def test_chaining_is_associative(a: Pose2, b: Pose2, c: Pose2) -> None:
    assert same((a @ b) @ c, a @ (b @ c))


@given(poses)
def test_the_pose_of_a_frame_in_itself_changes_nothing(a: Pose2) -> None:
    assert same(a @ Pose2(), a)
    assert same(Pose2() @ a, a)


@given(poses)
def test_there_and_back_is_nowhere_from_both_sides(a: Pose2) -> None:
    assert same(a @ a.inverse(), Pose2())
    assert same(a.inverse() @ a, Pose2())
    assert same(a.inverse().inverse(), a)


@given(poses, poses)
def test_the_inverse_of_a_chain_is_the_chain_of_inverses_backwards(a: Pose2, b: Pose2) -> None:
    assert same((a @ b).inverse(), b.inverse() @ a.inverse())


def test_a_chain_turns_before_it_goes_on() -> None:
    assert same(Pose2(1, 2, math.pi / 2) @ Pose2(3, 0, 0.1), Pose2(1, 5, math.pi / 2 + 0.1))


@given(poses, poses, st.tuples(lengths, lengths))
def test_points_go_through_a_chain_as_through_its_links(
    a: Pose2, b: Pose2, point: tuple[float, float]
) -> None:
    points = np.array([point, (0.0, 0.0)])
    np.testing.assert_allclose((a @ b).apply(points), a.apply(b.apply(points)), atol=1e-9)
    np.testing.assert_allclose((a @ b).apply(points)[1], [(a @ b).x, (a @ b).y], atol=1e-9)
    np.testing.assert_allclose(a.inverse().apply(a.apply(points)), points, atol=1e-9)


@given(poses)
def test_a_pose_survives_being_an_array(a: Pose2) -> None:
    assert same(Pose2.from_array(a.to_array()), a, 1e-14)


@given(poses, poses)
def test_turning_to_another_heading_is_the_short_way(a: Pose2, b: Pose2) -> None:
    turn = a.turn_to(b)
    assert -math.pi <= turn < math.pi
    assert abs(wrap_angle(a.theta + turn - b.theta)) < 1e-12


def by_euler(twist: Twist2, duration: float, steps: int) -> tuple[float, float, float]:
    """Midpoint steps; the heading is not wrapped."""
    x = y = 0.0
    part = duration / steps
    for step in range(steps):
        heading = twist.omega * (step + 0.5) * part
        x += twist.v * part * math.cos(heading)
        y += twist.v * part * math.sin(heading)
    return x, y, twist.omega * duration


@given(st.floats(-2, 2), st.floats(-6, 6), st.floats(-3, 3))
def test_integrating_a_twist_is_the_limit_of_many_small_steps(
    v: float, omega: float, duration: float
) -> None:
    x, y, theta = by_euler(Twist2(v, omega), duration, 2000)
    assert same(Twist2(v, omega).integrate(duration), Pose2(x, y, theta), 1e-4)


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("turn", [0.0, 1e-12, 9.9e-5, 1e-4, 1.01e-4, 1e-3])
def test_nothing_jumps_where_the_small_angle_formula_begins(turn: float, sign: int) -> None:
    """By the series with two more terms than can matter."""
    t = sign * turn
    found = Twist2(0.5, t / 2).integrate(2.0)
    assert found.x == pytest.approx(1 - t**2 / 6 + t**4 / 120, abs=1e-15, rel=1e-15)
    assert found.y == pytest.approx(t / 2 - t**3 / 24 + t**5 / 720, abs=2e-12)
    assert found.theta == pytest.approx(t, abs=1e-15)


@given(st.floats(-1, 1), st.floats(-5, 5), st.floats(0, 2), st.floats(0, 2))
def test_a_twist_held_on_is_its_parts_chained(
    v: float, omega: float, first: float, then: float
) -> None:
    twist = Twist2(v, omega)
    assert same(twist.integrate(first) @ twist.integrate(then), twist.integrate(first + then))


@given(st.floats(-1, 1), st.floats(-5, 5), st.floats(0, 2))
def test_time_backwards_undoes_a_twist(v: float, omega: float, duration: float) -> None:
    twist = Twist2(v, omega)
    assert same(twist.integrate(duration) @ twist.integrate(-duration), Pose2())


def test_a_full_circle_ends_where_it_began() -> None:
    assert same(Twist2(0.15, 0.79).integrate(2 * math.pi / 0.79), Pose2(), 1e-12)


def test_half_way_round_the_turn_is_taken_the_short_way() -> None:
    between = interpolate(Pose2(0, 0, 3.1), Pose2(1, 2, -3.1), 0.5)
    assert same(between, Pose2(0.5, 1, math.pi))


@given(poses, poses)
def test_interpolation_begins_and_ends_at_its_ends(a: Pose2, b: Pose2) -> None:
    assert same(interpolate(a, b, 0), a)
    assert same(interpolate(a, b, 1), b)


@given(st.lists(st.floats(-math.pi, 3.14159), min_size=1, max_size=5))
def test_headings_as_vectors_are_of_unit_length_and_come_back(angles: list[float]) -> None:
    vectors = heading_vectors(np.array(angles))
    assert vectors.shape == (len(angles), 2)
    np.testing.assert_allclose((vectors**2).sum(axis=1), 1)
    np.testing.assert_allclose(wrap_angle(heading_angles(vectors) - angles), 0, atol=1e-12)


@given(st.lists(poses, min_size=1, max_size=6), st.lists(poses, min_size=6, max_size=6))
def test_arrays_of_poses_are_chained_as_poses_are(some: list[Pose2], moves: list[Pose2]) -> None:
    array = np.array([pose.to_array() for pose in some])
    before = array.copy()
    each = compose(array, np.array([move.to_array() for move in moves[: len(some)]]))
    by_one = compose(array, moves[0].to_array())
    for place, pose in enumerate(some):
        assert same(Pose2.from_array(each[place]), pose @ moves[place])
        assert same(Pose2.from_array(by_one[place]), pose @ moves[0])
    assert (each[:, 2] >= -math.pi).all() and (each[:, 2] < math.pi).all()
    np.testing.assert_array_equal(array, before)


def test_the_mean_heading_of_a_cloud_across_minus_pi_is_there_and_not_at_zero() -> None:
    cloud = np.array([[1.0, 0.0, math.pi - 0.1], [3.0, 2.0, -math.pi + 0.1]])
    assert same(mean_pose(cloud, np.array([1.0, 1.0])), Pose2(2, 1, math.pi))
    tilted = mean_pose(cloud, np.array([3.0, 1.0]))
    assert tilted.x == pytest.approx(1.5)
    assert tilted.turn_to(Pose2(0, 0, math.pi - 0.05)) == pytest.approx(0, abs=2e-4)


@given(poses, st.integers(0, 2**32 - 1))
def test_mean_and_covariance_do_not_depend_on_where_the_cloud_looks(
    about: Pose2, seed: int
) -> None:
    """Turned as a whole, also across -pi, the mean turns along and the covariance with it."""
    rng = np.random.default_rng(seed)
    cloud = rng.normal(0, [0.3, 0.1, 0.2], (40, 3))
    weights = rng.uniform(0.1, 3, 40)
    plain = mean_pose(cloud, weights)
    moved = np.array([(about @ Pose2.from_array(one)).to_array() for one in cloud])
    mean = mean_pose(moved, weights)
    assert same(mean, about @ plain)
    c, s = math.cos(about.theta), math.sin(about.theta)
    turned = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    expected = turned @ pose_covariance(cloud, weights, plain) @ turned.T
    np.testing.assert_allclose(pose_covariance(moved, weights, mean), expected, atol=1e-9)


def test_the_covariance_is_the_weighted_one() -> None:
    rng = np.random.default_rng(0)
    cloud = rng.normal(0, [0.3, 0.1, 0.2], (50, 3))
    weights = rng.uniform(0, 1, 50)
    mean = Pose2.from_array(np.average(cloud, axis=0, weights=weights))
    before = cloud.copy()
    found = pose_covariance(cloud, weights, mean)
    np.testing.assert_allclose(found, np.cov(cloud.T, aweights=weights, bias=True), atol=1e-12)
    np.testing.assert_array_equal(cloud, before)
