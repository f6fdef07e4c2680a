"""From twist to wheels and back."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robot.description.spec import RobotSpec
from robot.driving.differential_drive import DifferentialDrive, WheelMultipliers
from robot.geometry import Twist2

SPEC = RobotSpec.load()
DRIVE = DifferentialDrive(SPEC)
UNEVEN = DifferentialDrive(SPEC.with_wheels([0.027, 0.030], 0.1))
speeds = st.floats(-2, 2)
turns = st.floats(-20, 20)
twists = st.builds(Twist2, speeds, turns)
drives = st.sampled_from([DRIVE, UNEVEN])


def test_multipliers_are_other_wheels() -> None:
    by = WheelMultipliers(left_radius=1.02, right_radius=0.99, separation=1.05)
    multiplied = DifferentialDrive(SPEC, by)
    left, right = SPEC.axle
    radii = [joint.radius for joint in SPEC.joints]
    radii[left] *= 1.02
    radii[right] *= 0.99
    other = DifferentialDrive(SPEC.with_wheels(radii, 1.05 * SPEC.track))
    np.testing.assert_allclose(
        multiplied.wheels(Twist2(0.1, 0.7)), other.wheels(Twist2(0.1, 0.7)), rtol=1e-12
    )
    assert multiplied.track == pytest.approx(1.05 * SPEC.track)
    turned = np.array([1.0, 1.3])
    assert multiplied.moved(turned) == other.moved(turned)


@given(drives, twists)
def test_wheels_and_twist_are_each_others_inverse(drive: DifferentialDrive, twist: Twist2) -> None:
    back = drive.twist(drive.wheels(twist))
    assert back.v == pytest.approx(twist.v, abs=1e-12)
    assert back.omega == pytest.approx(twist.omega, abs=1e-12)


def test_straight_ahead_both_wheels_turn_alike() -> None:
    np.testing.assert_allclose(DRIVE.wheels(Twist2(0.28, 0)), [10, 10])


def test_turning_left_the_right_wheel_rolls_forward() -> None:
    wheels = DRIVE.wheels(Twist2(0, 1))
    assert wheels[DRIVE.right] == pytest.approx(0.056 / 0.028)
    assert wheels[DRIVE.left] == pytest.approx(-0.056 / 0.028)


def test_the_smaller_wheel_must_turn_faster() -> None:
    left, right = UNEVEN.wheels(Twist2(0.27, 0))
    assert [left, right] == pytest.approx([10, 9])


@given(drives, twists)
def test_moved_is_the_arc_of_the_twist(drive: DifferentialDrive, twist: Twist2) -> None:
    moved, arc = drive.moved(drive.wheels(twist) * 0.02), twist.integrate(0.02)
    assert moved.distance_to(arc) < 1e-12
    assert abs(moved.turn_to(arc)) < 1e-12


def test_a_half_circle_ends_beside_its_start() -> None:
    moved = DRIVE.moved(DRIVE.wheels(Twist2(0.1 * math.pi, math.pi)))
    assert [moved.x, moved.y] == pytest.approx([0, 0.2], abs=1e-12)


@given(drives, twists)
def test_limited_no_wheel_passes_its_limit_and_the_curve_stays(
    drive: DifferentialDrive, twist: Twist2
) -> None:
    limited = drive.limit(twist)
    tops = np.array([joint.max_velocity for joint in drive.spec.joints])
    assert (np.abs(drive.wheels(limited)) <= tops * (1 + 1e-12)).all()
    assert limited.v * twist.omega == pytest.approx(limited.omega * twist.v, abs=1e-9)
    assert abs(limited.v) <= abs(twist.v)


@given(drives, twists)
def test_limiting_is_needed_once_and_changes_nothing_that_is_possible(
    drive: DifferentialDrive, twist: Twist2
) -> None:
    once = drive.limit(twist)
    again = drive.limit(once)
    assert again.v == pytest.approx(once.v) and again.omega == pytest.approx(once.omega)
    slow = Twist2(0.1 * math.tanh(twist.v), 0.1 * math.tanh(twist.omega))
    assert drive.limit(slow) == slow


def test_the_specs_limits_are_where_the_wheels_limits_are() -> None:
    for twist in (Twist2(SPEC.max_v, 0), Twist2(0, SPEC.max_omega)):
        top = np.abs(DRIVE.wheels(twist)).max()
        assert top == pytest.approx(SPEC.joints[0].max_velocity)
