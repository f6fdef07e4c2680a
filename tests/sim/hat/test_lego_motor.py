"""What a LEGO motor tells of its shaft, and how the firmware lists it."""

from __future__ import annotations

import math
from itertools import pairwise

import pytest
from hat_boards import LISTED_BLOCK
from hypothesis import example, given
from hypothesis import strategies as st

from sim.hat.lego_motor import APOS, CALIB, MODES, POS, POWER, SPEED, STATS, LegoMotor
from sim.hat.motor_figures import MOTOR_FIGURES, DeviceError


class Shaft:
    """A plant that the test turns by hand."""

    def __init__(self, angle: float = 0.0) -> None:
        self.angle = angle
        self.speed = 0.0

    def drive(self, duty: float | None) -> None:
        raise AssertionError("a motor's electronics do not drive it")


def turned(shaft: Shaft, motor: LegoMotor, speed: float, seconds: float, start: float = 0) -> float:
    """Turn it evenly [deg/s] in steps of 1 ms, sampling at each; returns the time."""
    begin = shaft.angle
    steps = round(seconds * 1000)
    for step in range(1, steps + 1):
        shaft.angle = begin + speed * step / 1000
        motor.sample(start + step / 1000)
    return start + seconds


def told(motor: LegoMotor, mode: int) -> int:
    (value,) = motor.read(mode)
    return value


def test_the_listing_is_the_firmwares_to_the_byte() -> None:
    motor = LegoMotor(0x4C, Shaft())
    assert motor.description(0) == LISTED_BLOCK.replace("\n", "\r\n")


@pytest.mark.parametrize("type_id", sorted(MOTOR_FIGURES))
def test_the_listing_names_port_and_type(type_id: int) -> None:
    lines = LegoMotor(type_id, Shaft()).description(3).split("\r\n")
    assert lines[0] == f"P3: connected to active ID {type_id:02X}"
    assert lines[1] == f"type {type_id:02X}"


def test_pos_starts_at_zero_at_power_up() -> None:
    shaft = Shaft(1234.0)
    motor = LegoMotor(0x30, shaft)
    assert told(motor, POS) == 0
    now = turned(shaft, motor, 500, 1.0)
    assert told(motor, POS) == 500
    motor.power_up()
    assert told(motor, POS) == 0
    turned(shaft, motor, -100, 1.0, now)
    assert told(motor, POS) == -100


def test_apos_keeps_its_mark_through_power_up() -> None:
    shaft = Shaft()
    motor = LegoMotor(0x30, shaft, mark=30)
    assert told(motor, APOS) == 30
    turned(shaft, motor, 100, 1.0)
    motor.power_up()
    assert told(motor, APOS) == 130


@given(st.floats(-1e6, 1e6), st.floats(-180, 180), st.floats(-1e4, 1e4))
def test_pos_and_apos_count_the_same_degrees(start: float, mark: float, turn: float) -> None:
    shaft = Shaft(start)
    motor = LegoMotor(0x31, shaft, mark=mark)
    before = told(motor, APOS)
    shaft.angle = start + turn
    motor.sample(0.01)
    assert abs(told(motor, POS) - turn) <= 1 + 1e-6
    assert (told(motor, APOS) - before - told(motor, POS)) % 360 == 0
    assert -180 <= told(motor, APOS) <= 179
    off = (told(motor, APOS) - (shaft.angle + mark) + 180) % 360 - 180
    assert abs(off) <= 0.5 + 1e-6


def test_apos_ends_at_179_and_goes_on_at_minus_180() -> None:
    for angle, apos in ((179, 179), (180, -180), (-180, -180), (-181, 179), (539, 179)):
        assert told(LegoMotor(0x30, Shaft(angle)), APOS) == apos


def test_pos_wraps_as_a_32_bit_number() -> None:
    shaft = Shaft()
    motor = LegoMotor(0x30, shaft)
    shaft.angle = 2.0**31
    motor.sample(0.01)
    assert told(motor, POS) == -(2**31)


@pytest.mark.parametrize(("speed", "units"), [(500, 50), (-500, -50), (951, 95), (44, 4), (0, 0)])
def test_speed_is_told_in_tens_of_degrees_a_second(speed: float, units: int) -> None:
    shaft = Shaft()
    motor = LegoMotor(0x30, shaft)
    turned(shaft, motor, speed, 0.5)
    assert told(motor, SPEED) == units


@pytest.mark.parametrize("sign", [1, -1])
def test_speed_ends_at_100_units(sign: int) -> None:
    shaft = Shaft()
    motor = LegoMotor(0x30, shaft)
    turned(shaft, motor, sign * 1500, 0.5)
    assert told(motor, SPEED) == sign * 100


def test_speed_follows_within_a_few_samples() -> None:
    shaft = Shaft()
    motor = LegoMotor(0x30, shaft)
    now = turned(shaft, motor, 500, 0.02)
    assert 25 <= told(motor, SPEED) <= 40
    now = turned(shaft, motor, 500, 0.08, now)
    assert told(motor, SPEED) == 50
    turned(shaft, motor, 0, 0.12, now)
    assert told(motor, SPEED) == 0


def test_what_turned_before_the_first_sample_is_no_speed() -> None:
    shaft = Shaft()
    motor = LegoMotor(0x30, shaft)
    shaft.angle = 300.0
    motor.sample(2.0)
    assert (told(motor, SPEED), told(motor, POS)) == (0, 300)
    motor.sample(2.01)
    assert told(motor, SPEED) == 0


ROUNDING = 1e-7
"""Which of two milliseconds a sample belongs to that falls on the border [s]."""


@given(st.floats(0, 0.0099))
@example(1e-8)  # the border is where the motor's own allowance for rounding ends
@example(0.00100001)
def test_values_stay_until_the_motors_own_next_sample(phase: float) -> None:
    shaft = Shaft()
    motor = LegoMotor(0x30, shaft, phase=phase)
    messages = []
    for step in range(1, 101):
        shaft.angle = float(step)
        before = told(motor, POS)
        if motor.sample(step / 1000):
            messages.append(step)
            assert told(motor, POS) == step
        else:
            assert told(motor, POS) == before
    # The first one comes as soon as there is power; from the second on its own clock rules.
    assert messages[0] == 1
    own = [divmod(step / 1000 - phase + ROUNDING, 0.01) for step in messages[1:]]
    assert {after - before for (before, _), (after, _) in pairwise(own)} == {1}
    assert all(late < 0.001 + 2 * ROUNDING for _, late in own)
    assert len(messages) >= 10


def test_a_clock_that_adds_up_milliseconds_gives_100_messages_a_second() -> None:
    motor = LegoMotor(0x30, Shaft())
    now, messages = 0.0, 0
    for _ in range(20_000):
        now += 0.001
        messages += motor.sample(now)
    assert messages == 1 + 2000


def test_a_motor_that_does_not_respond_sends_nothing_and_goes_on_later() -> None:
    shaft = Shaft()
    motor = LegoMotor(0x30, shaft)
    now = turned(shaft, motor, 100, 1.0)
    motor.responding = False
    now = turned(shaft, motor, 100, 1.0, now)
    assert told(motor, POS) == 100
    motor.responding = True
    turned(shaft, motor, 100, 0.01, now)
    assert told(motor, POS) == 201
    assert told(motor, SPEED) == 10


def test_values_fit_their_mode() -> None:
    motor = LegoMotor(0x41, Shaft())
    for mode, described in enumerate(MODES):
        assert len(motor.read(mode)) == described.count
    assert motor.read(POWER) == (0,)
    assert motor.read(CALIB) == (0, 0)
    assert motor.read(STATS) == (0,) * 14
    sizes = [MODES[mode].type.size for mode in motor.combinations[0]]
    assert sizes == [1, 4, 2]


@pytest.mark.parametrize("mode", [-1, 6, 15])
def test_a_mode_that_is_not_there_is_refused(mode: int) -> None:
    with pytest.raises(DeviceError, match="0 to 5"):
        LegoMotor(0x30, Shaft()).read(mode)


def test_a_type_that_is_no_angular_motor_is_refused() -> None:
    with pytest.raises(DeviceError, match="4C"):
        LegoMotor(0x3D, Shaft())


def test_connecting_takes_as_long_as_it_is_told_to() -> None:
    slow = LegoMotor(0x30, Shaft(), connect_seconds=9.0)
    assert slow.connect_seconds == 9.0
    assert math.isclose(LegoMotor(0x30, Shaft()).connect_seconds, 2.0)
