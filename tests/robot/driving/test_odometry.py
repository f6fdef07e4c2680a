"""Dead reckoning adds up what the wheels did, and knows how little that is."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robot.description.spec import RobotSpec
from robot.driving.differential_drive import DifferentialDrive
from robot.driving.odometry import Odometry, OdometrySettings, OdometryState
from robot.geometry import Pose2, Twist2, wrap_angle
from robot.interface import Reading

DRIVE = DifferentialDrive(RobotSpec.load())
PERIOD = 0.02


def reading(stamp: float, positions: np.ndarray, velocities: np.ndarray | None = None) -> Reading:
    return Reading(stamp, positions, np.zeros(2) if velocities is None else velocities)


def driven(
    twist: Twist2, seconds: float, settings: OdometrySettings = OdometrySettings()
) -> tuple[Odometry, list[OdometryState]]:
    """An odometry that has seen a twist held, with exact wheels, and all its states."""
    odometry, wheels = Odometry(DRIVE, settings), DRIVE.wheels(twist)
    steps = range(round(seconds / PERIOD) + 1)
    return odometry, [
        odometry.update(reading(i * PERIOD, wheels * i * PERIOD, wheels)) for i in steps
    ]


def near(pose: Pose2, other: Pose2, tolerance: float = 1e-9) -> bool:
    return pose.distance_to(other) < tolerance and abs(pose.turn_to(other)) < tolerance


def test_it_begins_at_its_origin_wherever_the_wheels_stand() -> None:
    state = Odometry(DRIVE, OdometrySettings()).update(reading(7.0, np.array([123.0, -45.0])))
    assert state.odom_from_robot == Pose2()
    assert state.stamp == 7.0
    np.testing.assert_array_equal(state.covariance, np.zeros((3, 3)))


@pytest.mark.parametrize(
    "twist",
    [Twist2(0.2, 0), Twist2(-0.2, 0), Twist2(0.15, 0.79), Twist2(-0.1, 2), Twist2(0, -2.5)],
)
def test_straights_arcs_and_turns_on_the_spot_are_exact(twist: Twist2) -> None:
    _, states = driven(twist, 3.0)
    for state in states:
        assert near(state.odom_from_robot, twist.integrate(state.stamp), 1e-9)
    assert states[-1].twist.v == pytest.approx(twist.v)
    assert states[-1].twist.omega == pytest.approx(twist.omega)


@pytest.mark.parametrize("joint", [0, 1])
@pytest.mark.parametrize("counted", [40.0, -40.0, 2.0])
def test_a_motor_that_counts_anew_moves_no_robot(joint: int, counted: float) -> None:
    """The plug of a motor is pulled and put back, and it begins again at nought."""
    twist = Twist2(0.15, 0.5)
    odometry, wheels = Odometry(DRIVE, OdometrySettings()), DRIVE.wheels(twist)
    for i in range(100):
        positions = wheels * i * PERIOD
        if i >= 50:
            positions[joint] -= counted
        state = odometry.update(reading(i * PERIOD, positions, wheels))
        assert (odometry.counted_anew == 50 * PERIOD) == (i >= 50)
    assert near(state.odom_from_robot, twist.integrate(99 * PERIOD), 1e-9)


@pytest.mark.parametrize("share", [1.0, 2.0])
def test_wheels_turn_as_fast_as_they_can_and_as_a_hand_turns_them(share: float) -> None:
    odometry, turned = Odometry(DRIVE, OdometrySettings()), share * DRIVE.limits * PERIOD
    for i in range(50):
        state = odometry.update(reading(i * PERIOD, turned * i))
    assert odometry.counted_anew == -math.inf
    assert near(state.odom_from_robot, DRIVE.moved(49 * turned), 1e-9)


def test_one_wheel_alone_turns_the_robot_about_the_other() -> None:
    odometry = Odometry(DRIVE, OdometrySettings())
    odometry.update(reading(0.0, np.zeros(2)))
    turned = np.zeros(2)
    track, radius = DRIVE.spec.track, DRIVE.spec.wheel_radius
    turned[DRIVE.right] = (math.pi / 2) * track / radius
    state = odometry.update(reading(1.0, turned))
    assert near(state.odom_from_robot, Pose2(track / 2, track / 2, math.pi / 2))


def test_the_twist_is_the_one_measured_and_not_the_one_of_the_positions() -> None:
    odometry = Odometry(DRIVE, OdometrySettings())
    odometry.update(reading(0.0, np.zeros(2)))
    state = odometry.update(reading(0.02, np.zeros(2), DRIVE.wheels(Twist2(0.1, 0.5))))
    assert (state.twist.v, state.twist.omega) == (pytest.approx(0.1), pytest.approx(0.5))
    assert state.odom_from_robot == Pose2()


# --- asked by stamp


@given(st.floats(0.0, 0.8))
def test_between_readings_the_pose_is_interpolated(stamp: float) -> None:
    twist = Twist2(0.2, 2.0)
    odometry, _ = driven(twist, 0.8)
    state = odometry.at(stamp)
    assert state.stamp == pytest.approx(stamp, abs=1e-12)
    # The chord of 4 mm and 0.04 rad lies within 0.02 mm of the arc.
    assert near(state.odom_from_robot, twist.integrate(stamp), 3e-5)


def test_at_a_reading_it_is_that_reading_exactly() -> None:
    odometry, states = driven(Twist2(0.2, 1.0), 0.5)
    for state in states:
        assert odometry.at(state.stamp).odom_from_robot == state.odom_from_robot


def test_the_heading_is_interpolated_the_short_way_across_half_a_turn() -> None:
    odometry, states = driven(Twist2(0.0, 2.0), 1.7)
    headings = [state.odom_from_robot.theta for state in states]
    assert max(headings) > 3.1 and min(headings) < -3.1, "the turn passes pi"
    for stamp in np.linspace(1.5, 1.65, 40):
        theta = odometry.at(float(stamp)).odom_from_robot.theta
        assert abs(wrap_angle(theta - 2.0 * float(stamp))) < 1e-9


def test_the_twist_between_two_readings_is_that_of_the_later_one() -> None:
    odometry = Odometry(DRIVE, OdometrySettings())
    for stamp, v in ((0.0, 0.0), (0.1, 0.1), (0.2, 0.3)):
        odometry.update(reading(stamp, np.zeros(2), DRIVE.wheels(Twist2(v))))
    assert odometry.at(0.15).twist.v == pytest.approx(0.3)
    assert odometry.at(0.05).twist.v == pytest.approx(0.1)


def test_beyond_the_newest_reading_it_is_the_newest() -> None:
    odometry, states = driven(Twist2(0.2, 0), 0.5)
    assert odometry.at(0.9) is states[-1]


def test_a_picture_from_just_before_the_first_reading_gets_the_first() -> None:
    odometry = Odometry(DRIVE, OdometrySettings())
    first = odometry.update(reading(10.0, np.zeros(2)))
    assert odometry.at(9.98) is first


def test_before_any_reading_there_is_nothing_to_be_asked() -> None:
    with pytest.raises(LookupError, match="no wheel reading"):
        Odometry(DRIVE, OdometrySettings()).at(0.0)


@pytest.mark.parametrize("stamp", [3.9, 3.0, 0.0, -5.0])
def test_what_is_forgotten_is_refused_and_the_limits_are_named(stamp: float) -> None:
    """The oldest that is left would be wrong by the way driven since."""
    odometry, _ = driven(Twist2(0.2, 0), 5.0)
    with pytest.raises(LookupError, match=rf"at {stamp:.3f} s .*kept from 3\.980 to 5\.000 s"):
        odometry.at(stamp)


def test_a_picture_from_long_before_the_first_reading_is_refused() -> None:
    odometry = Odometry(DRIVE, OdometrySettings())
    odometry.update(reading(10.0, np.zeros(2)))
    with pytest.raises(LookupError, match=r"at 8\.900 s"):
        odometry.at(8.9)


@pytest.mark.parametrize("history", [0.05, 0.5, 1.0])
def test_what_is_promised_to_be_remembered_is_exact(history: float) -> None:
    twist = Twist2(0.2, 1.0)
    odometry, _ = driven(twist, 3.0, OdometrySettings(history=history))
    for stamp in np.linspace(3.0 - history, 3.0, 30):
        assert near(odometry.at(float(stamp)).odom_from_robot, twist.integrate(float(stamp)), 3e-5)


def test_a_pause_between_readings_is_bridged() -> None:
    """Longer than the history: at least the two last readings are kept."""
    odometry = Odometry(DRIVE, OdometrySettings(history=0.1))
    wheels = DRIVE.wheels(Twist2(0.2, 0))
    for stamp in (0.0, 0.02, 5.0):
        odometry.update(reading(stamp, wheels * stamp, wheels))
    assert near(odometry.at(2.5).odom_from_robot, Pose2(0.5), 1e-9)


@pytest.mark.parametrize("stamp", [0.5, 0.3, -1.0, math.nan])
def test_stamps_that_do_not_rise_are_refused_and_nothing_is_lost(stamp: float) -> None:
    twist = Twist2(0.2, 0)
    odometry, states = driven(twist, 0.5)
    with pytest.raises(ValueError, match="stamps must rise"):
        odometry.update(reading(stamp, DRIVE.wheels(twist) * 9.0))
    assert odometry.at(0.5) is states[-1]
    state = odometry.update(reading(0.52, DRIVE.wheels(twist) * 0.52))
    assert near(state.odom_from_robot, Pose2(0.2 * 0.52))


# --- covariance


@given(
    st.lists(st.tuples(st.floats(-0.3, 0.3), st.floats(-2.5, 2.5)), min_size=1, max_size=12),
    st.floats(0, 0.01),
)
def test_the_covariance_is_symmetric_positive_and_grows(
    twists: list[tuple[float, float]], wheel_error: float
) -> None:
    odometry = Odometry(DRIVE, OdometrySettings(wheel_error=wheel_error))
    positions, last = np.zeros(2), 0.0
    odometry.update(reading(0.0, positions))
    for step, (v, omega) in enumerate(twists):
        positions = positions + DRIVE.wheels(Twist2(v, omega)) * 0.1
        covariance = odometry.update(reading((step + 1) * 0.1, positions)).covariance
        np.testing.assert_allclose(covariance, covariance.T, atol=1e-15)
        assert np.linalg.eigvalsh(covariance).min() > -1e-12
        assert covariance[2, 2] >= last - 1e-15, "the heading never gets surer"
        last = covariance[2, 2]


def test_standing_still_costs_no_certainty() -> None:
    odometry, states = driven(Twist2(0.2, 1.0), 0.5)
    wheels = DRIVE.wheels(Twist2(0.2, 1.0)) * 0.5
    later = odometry.update(reading(60.0, wheels))
    np.testing.assert_array_equal(later.covariance, states[-1].covariance)


def test_the_covariance_of_a_straight_is_the_closed_form() -> None:
    """Wheels err independently, their variance k by travel: the heading's is 2 k d / track^2."""
    k, distance = 2e-4, 0.6
    _, states = driven(Twist2(0.2, 0), 3.0, OdometrySettings(wheel_error=k))
    covariance = states[-1].covariance
    heading = 2 * k * distance / DRIVE.spec.track**2
    assert covariance[2, 2] == pytest.approx(heading, rel=1e-6)
    assert covariance[0, 0] == pytest.approx(k * distance / 2, rel=1e-6)
    # Aside the heading's error adds up along the way.
    assert covariance[1, 1] == pytest.approx(heading * distance**2 / 3, rel=0.02)
    assert covariance[1, 2] == pytest.approx(heading * distance / 2, rel=0.02)


@pytest.mark.parametrize("twist", [Twist2(0.15, 0.79), Twist2(-0.2, 1.2), Twist2(0, 1.5)])
def test_the_covariance_is_that_of_many_runs_with_such_wheels(twist: Twist2) -> None:
    """2000 runs of 2 s whose wheels slip at random, added up without the class under test."""
    k, steps, runs = 2e-4, 100, 2000
    _, states = driven(twist, 2.0, OdometrySettings(wheel_error=k))
    rng = np.random.default_rng(0)
    travel = DRIVE.wheels(twist) * PERIOD * DRIVE.spec.wheel_radius
    sd = np.sqrt(k * np.abs(travel))
    x, y, theta = np.zeros((3, runs))
    for _ in range(steps):
        left, right = (
            travel[i] + sd[i] * rng.standard_normal(runs) for i in (DRIVE.left, DRIVE.right)
        )
        ahead, turn = (left + right) / 2, (right - left) / DRIVE.spec.track
        x += ahead * np.cos(theta + turn / 2)
        y += ahead * np.sin(theta + turn / 2)
        theta += turn
    sampled = np.cov(np.stack([x, y, theta]))
    scale = np.sqrt(np.outer(np.diag(sampled), np.diag(sampled)))
    # 2000 runs know a correlation to about 0.03.
    np.testing.assert_allclose(states[-1].covariance / scale, sampled / scale, atol=0.1)
