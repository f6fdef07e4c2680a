"""Free motors turn as measured ones do: speed, torque, time constant, friction, brake, coast."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sim.hat.motor_figures import (
    MOTOR_FIGURES,
    RAIL_V,
    SUPPLY_V,
    DeviceError,
    MotorFigures,
    figures_described,
    figures_named,
)
from sim.hat.plants import FreeMotor, FreeMotors, Plant, Plants

KINDS = pytest.mark.parametrize(
    "figures", [figures_named(name) for name in ("medium", "large", "small")]
)
DUTIES = st.none() | st.floats(-1, 1)
LOADS = st.floats(-0.2, 0.2)


def at_test_voltage(figures: MotorFigures) -> FreeMotor:
    """At the voltage at which the figures were measured."""
    motor = FreeMotor(figures)
    motor.supply_v = figures.volts * SUPPLY_V / RAIL_V
    return motor


def run(motor: FreeMotor, seconds: float) -> None:
    for _ in range(round(seconds * 1000)):
        motor.step(0.001)


def settled(motor: FreeMotor, duty: float) -> float:
    motor.drive(duty)
    run(motor, 1.0)
    return motor.speed


def threshold(figures: MotorFigures) -> float:
    """The least duty, in steps of 1/1000, that makes a standing motor turn."""
    for thousandth in range(1000):
        motor = FreeMotor(figures)
        motor.drive(thousandth / 1000)
        motor.step(0.001)
        if motor.speed > 0:
            return thousandth / 1000
    raise AssertionError("it never turned")


@KINDS
def test_without_a_load_it_reaches_the_measured_speed(figures: MotorFigures) -> None:
    assert settled(at_test_voltage(figures), 1.0) == pytest.approx(figures.no_load_speed, rel=1e-6)


@pytest.mark.parametrize(
    ("name", "torque", "speed"),
    [("large", 0.0999, 728), ("medium", 0.0999, 264), ("small", 0.0312, 315)],
)
def test_at_the_rated_load_it_reaches_the_measured_speed(
    name: str, torque: float, speed: float
) -> None:
    motor = at_test_voltage(figures_named(name))
    motor.load = torque
    assert settled(motor, 1.0) == pytest.approx(speed, rel=0.01)


@pytest.mark.parametrize(
    ("name", "torque", "speed"),
    [("large", 0, 1050), ("large", 0.08, 810), ("medium", 0, 1110), ("medium", 0.035, 810)],
)
def test_legos_own_sheet_is_met_within_its_tolerance(
    name: str, torque: float, speed: float
) -> None:
    motor = FreeMotor(figures_named(name))
    motor.load = torque
    assert settled(motor, 1.0) == pytest.approx(speed, rel=0.15)


@KINDS
def test_the_stall_torque_stops_it(figures: MotorFigures) -> None:
    motor = at_test_voltage(figures)
    settled(motor, 1.0)
    motor.load = 0.99 * figures.stall_torque
    assert settled(motor, 1.0) == pytest.approx(0.01 * figures.no_load_speed, rel=1e-3)
    motor.load = 1.01 * figures.stall_torque
    assert settled(motor, 1.0) == 0


@pytest.mark.parametrize(("name", "tau"), [("large", 0.048), ("medium", 0.036), ("small", 0.035)])
def test_it_gains_63_percent_of_its_speed_in_the_measured_time(name: str, tau: float) -> None:
    motor = at_test_voltage(figures_named(name))
    motor.drive(1.0)
    motor.step(motor.figures.time_constant)
    assert motor.speed == pytest.approx((1 - math.exp(-1)) * motor.figures.no_load_speed)
    assert motor.figures.time_constant == pytest.approx(tau, abs=0.0005)


@KINDS
def test_it_starts_with_the_measured_acceleration(figures: MotorFigures) -> None:
    motor = at_test_voltage(figures)
    motor.drive(1.0)
    motor.step(1e-5)
    assert motor.speed / 1e-5 == pytest.approx(figures.acceleration, rel=1e-3)


@KINDS
def test_a_standing_motor_needs_8_to_15_percent_to_turn(figures: MotorFigures) -> None:
    assert 0.08 <= threshold(figures) <= 0.15


@KINDS
def test_what_holds_it_standing_is_no_less_than_what_slows_it(figures: MotorFigures) -> None:
    assert figures.breakaway >= figures.friction


@pytest.mark.parametrize("name", ["large", "medium"])
def test_a_unit_of_duty_is_worth_950_to_1050_degrees_a_second(name: str) -> None:
    assert 950 <= settled(FreeMotor(figures_named(name)), 1.0) <= 1050


@KINDS
def test_both_ways_are_alike(figures: MotorFigures) -> None:
    ahead, back = FreeMotor(figures), FreeMotor(figures)
    assert settled(ahead, 0.6) == -settled(back, -0.6)
    assert ahead.angle == -back.angle


@KINDS
def test_speed_grows_with_the_supply(figures: MotorFigures) -> None:
    friction = figures.friction * figures.speed_per_torque
    full, low = FreeMotor(figures), FreeMotor(figures)
    low.supply_v = SUPPLY_V / 2
    assert settled(low, 1.0) + friction == pytest.approx((settled(full, 1.0) + friction) / 2)


@KINDS
def test_brake_stops_within_a_few_time_constants_and_stays(figures: MotorFigures) -> None:
    motor = FreeMotor(figures)
    settled(motor, 1.0)
    motor.drive(0.0)
    motor.step(3 * figures.time_constant)
    stood = motor.angle
    run(motor, 0.1)
    assert motor.speed == 0
    assert motor.angle == stood


@KINDS
def test_coasting_is_slowed_by_friction_alone(figures: MotorFigures) -> None:
    motor = at_test_voltage(figures)
    start = settled(motor, 1.0)
    slowing = figures.friction * figures.speed_per_torque / figures.time_constant
    angle = motor.angle
    motor.drive(None)
    motor.step(start / slowing / 2)
    assert motor.speed == pytest.approx(start / 2)
    motor.step(start / slowing)
    assert motor.speed == 0
    assert motor.angle - angle == pytest.approx(start**2 / slowing / 2)


@KINDS
def test_a_brake_lets_a_weight_down_slower_than_a_coasting_motor(figures: MotorFigures) -> None:
    braking, coasting = FreeMotor(figures), FreeMotor(figures)
    braking.load = coasting.load = 0.9 * figures.stall_torque
    braking.drive(0.0)
    coasting.drive(None)
    run(braking, 0.5)
    run(coasting, 0.5)
    assert coasting.speed < 2 * braking.speed < 0


def test_a_light_weight_is_held_by_friction() -> None:
    motor = FreeMotor(figures_named("large"))
    motor.load = 0.04
    run(motor, 0.5)
    assert motor.angle == 0


def test_a_blocked_shaft_stands_and_starts_again_when_it_is_free() -> None:
    motor = FreeMotor(figures_named("medium"))
    settled(motor, 0.5)
    motor.stalled = True
    stood = motor.angle
    run(motor, 0.1)
    assert (motor.angle, motor.speed) == (stood, 0.0)
    motor.stalled = False
    run(motor, 0.1)
    assert motor.angle > stood
    assert motor.speed > 0


@given(DUTIES, DUTIES, LOADS, st.integers(1, 40), st.sampled_from(sorted(MOTOR_FIGURES)))
def test_many_small_steps_are_one_large_one(
    before: float | None, after: float | None, load: float, pieces: int, type_id: int
) -> None:
    whole, cut = FreeMotor(MOTOR_FIGURES[type_id]), FreeMotor(MOTOR_FIGURES[type_id])
    for motor in (whole, cut):
        motor.drive(before)
        motor.step(0.1)
        motor.load = load
        motor.drive(after)
    whole.step(0.2)
    for _ in range(pieces):
        cut.step(0.2 / pieces)
    assert cut.speed == pytest.approx(whole.speed, rel=1e-6, abs=1e-6)
    assert cut.angle == pytest.approx(whole.angle, rel=1e-6, abs=1e-6)


@given(st.lists(st.tuples(DUTIES, LOADS), min_size=1, max_size=10))
def test_the_angle_is_what_the_speed_adds_up_to(drives: list[tuple[float | None, float]]) -> None:
    motor = FreeMotor(figures_named("small"))
    for duty, load in drives:
        motor.drive(duty)
        motor.load = load
        for _ in range(10):
            speed, angle = motor.speed, motor.angle
            motor.step(0.0001)
            # Between its two ends the speed runs evenly, but for the moment of a turn.
            most = max(abs(speed), abs(motor.speed), 0.1 * abs(speed - motor.speed))
            assert abs(motor.angle - angle) <= most * 0.0001 + 1e-9


@given(st.floats(-0.13, 0.13), st.floats(0, 1))
def test_what_stands_below_the_threshold_never_creeps(duty: float, seconds: float) -> None:
    motor = FreeMotor(figures_named("medium"))
    motor.drive(duty)
    motor.step(seconds)
    assert (motor.angle, motor.speed) == (0.0, 0.0)


@pytest.mark.parametrize("duty", [1.01, -2.0, math.nan, math.inf])
def test_a_duty_beyond_full_drive_is_refused(duty: float) -> None:
    with pytest.raises(DeviceError, match="-1 to 1"):
        FreeMotor(figures_named("large")).drive(duty)


def test_a_load_that_is_no_number_is_refused() -> None:
    with pytest.raises(DeviceError, match="N m"):
        FreeMotor(figures_named("large")).load = math.nan


def test_free_motors_step_together_at_four_ports() -> None:
    motors: Plants = FreeMotors({2: figures_named("large")})
    for port in range(4):
        motors.plant(port).drive(0.5 if port % 2 else -0.5)
    motors.step(0.1)
    plants: list[Plant] = [motors.plant(port) for port in range(4)]
    assert [math.copysign(1, plant.speed) for plant in plants] == [-1, 1, -1, 1]
    assert plants[0].angle != plants[2].angle


def test_free_motors_share_the_supply() -> None:
    motors = FreeMotors()
    motors.supply_v = 7.0
    assert [motors.plant(port).supply_v for port in range(4)] == [7.0] * 4
    assert motors.supply_v == 7.0


def test_ports_are_0_to_3() -> None:
    with pytest.raises(DeviceError, match="0 to 3"):
        FreeMotors().plant(4)
    with pytest.raises(DeviceError, match="0 to 3"):
        FreeMotors({-1: figures_named("small")})


def test_an_unknown_motor_is_answered_by_those_that_are_known() -> None:
    with pytest.raises(DeviceError, match=r"are medium, large, small, medium-grey, large-grey$"):
        figures_named("huge")
    with pytest.raises(DeviceError, match=r"are medium angular, large angular, small angular$"):
        figures_described("medium linear")


@pytest.mark.parametrize(
    ("kind", "name"), [("large angular", "large"), ("small angular", "small"), (None, "medium")]
)
def test_a_description_may_name_a_motor_or_leave_it_open(kind: str | None, name: str) -> None:
    assert figures_described(kind) == figures_named(name)
