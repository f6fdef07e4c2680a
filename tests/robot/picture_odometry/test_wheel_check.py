"""Stuck, slipping, pushed and lifted robots are told by name, and others are not."""

import numpy as np
import pytest

from robot.geometry import Twist2
from robot.picture_odometry.odometer import UNKNOWN, PictureMotion
from robot.picture_odometry.wheel_check import WheelCheck, WheelState

PERIOD = 1 / 30
DRIVES = Twist2(0.12, 0.3)
STANDS = Twist2()
SEEN = np.diag(np.square([0.0001, 0.0001, 0.0003]))


def step(
    check: WheelCheck,
    count: int,
    floor: Twist2,
    wheels: Twist2,
    *,
    larger: float = 0.0,
    seen: int = 3,
    covariance: np.ndarray = SEEN,
) -> WheelState:
    return check.add(
        PictureMotion(
            begin=count * PERIOD,
            end=(count + 1) * PERIOD,
            motion=floor.integrate(PERIOD),
            covariance=covariance if seen else np.eye(3) * UNKNOWN**2,
            seen=seen,
            alike=0.98 if seen else 0.1,
            predicted=wheels.integrate(PERIOD),
            larger=larger,
            larger_sd=0.0003 if seen == 3 else np.inf,
            textured=True,
        )
    )


def told(floor: Twist2, wheels: Twist2, before: Twist2 = DRIVES, **how) -> tuple[WheelState, float]:
    """Return what is told of something that begins after a second of driving, and after how long"""
    check = WheelCheck()
    for count in range(30):
        assert step(check, count, before, before) in (WheelState.ROLLING, WheelState.UNKNOWN)
    for count in range(30, 60):
        state = step(check, count, floor, wheels, **how)
        if state is not WheelState.ROLLING:
            return state, (count - 29) * PERIOD
    return WheelState.ROLLING, np.inf


@pytest.mark.parametrize(
    ("floor", "wheels", "before", "expected"),
    [
        (STANDS, DRIVES, DRIVES, WheelState.STUCK),
        (STANDS, Twist2(0.04, 0.0), Twist2(0.04, 0.0), WheelState.STUCK),
        (STANDS, Twist2(0.0, 1.5), Twist2(0.0, 1.5), WheelState.STUCK),
        (Twist2(0.3, 0.0), STANDS, STANDS, WheelState.PUSHED),
        (Twist2(0.3, 0.0), DRIVES, DRIVES, WheelState.PUSHED),
        (Twist2(0.06, 0.3), DRIVES, DRIVES, WheelState.SLIPPING),
    ],
)
def test_wheels_that_do_not_roll_are_named_within_a_third_of_a_second(
    floor, wheels, before, expected
):
    state, seconds = told(floor, wheels, before)
    assert state is expected
    assert seconds <= 0.3


def test_a_floor_that_grows_is_a_robot_in_the_air():
    state, seconds = told(DRIVES, DRIVES, larger=-0.012)
    assert state is WheelState.LIFTED and seconds <= 0.3


def test_pictures_that_are_not_alike_any_more_tell_nothing():
    """Tape left the view of a bare floor, or somebody switched the light off."""
    state, _ = told(DRIVES, DRIVES, seen=0)
    assert state is WheelState.UNKNOWN


@pytest.mark.parametrize("seed", range(3))
def test_worn_wheels_on_a_smooth_floor_roll(seed):
    """5 % of a radius, 2 % of slip, 0.3 mm of noise: as the simulated robot has them at worst."""
    rng = np.random.default_rng(seed)
    check, states = WheelCheck(), set()
    for count in range(900):
        wheels = Twist2(0.15 * np.sin(count / 50), np.cos(count / 80))
        share = 1.05 + 0.02 * rng.standard_normal()
        noise = rng.normal(0, (0.0003, 0.003)) / PERIOD
        floor = Twist2(wheels.v * share + noise[0], wheels.omega * share + noise[1])
        loose = np.diag(np.square([0.0003, 0.0003, 0.003]))
        states.add(step(check, count, floor, wheels, covariance=loose))
    assert states <= {WheelState.ROLLING, WheelState.UNKNOWN}


def test_along_an_edge_nothing_is_said_of_wheels_that_turn():
    """Straight tape across the way would tell, but along it all motions look alike."""
    along = SEEN + np.diag([UNKNOWN**2, 0, 0])
    state, _ = told(Twist2(0.12, 0.0), DRIVES, seen=2, covariance=along)
    assert state is WheelState.ROLLING


def test_where_nothing_is_seen_nothing_is_known():
    check = WheelCheck()
    assert all(
        step(check, count, STANDS, STANDS, seen=0) is WheelState.UNKNOWN for count in range(60, 90)
    )
