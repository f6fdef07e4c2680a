"""Whatever is asked for, the robot gets what it can do, and stops when nobody asks any more."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robot.description.spec import RobotSpec
from robot.driving.differential_drive import DifferentialDrive
from robot.driving.drive_controller import DriveController, DriveSettings
from robot.geometry import Twist2

SPEC = RobotSpec.load()
DRIVE = DifferentialDrive(SPEC)
LIMITS = DriveSettings()
PERIOD = 0.02
TOPS = np.array([joint.max_velocity for joint in SPEC.joints])


def run(
    controller: DriveController,
    wanted: Twist2 | Callable[[int], Twist2],
    seconds: float,
    since: float = 0.0,
) -> list[Twist2]:
    """Renew a command at each tick."""
    applied = []
    for tick in range(round(seconds / PERIOD)):
        stamp = since + tick * PERIOD
        controller.command(wanted if isinstance(wanted, Twist2) else wanted(tick), stamp)
        applied.append(controller.update(stamp))
    return applied


@pytest.fixture
def controller() -> DriveController:
    return DriveController(DRIVE, LIMITS)


def test_it_stands_until_it_is_asked(controller: DriveController) -> None:
    for stamp in (0.0, 0.02, 100.0):
        assert controller.update(stamp) == Twist2()
        assert not controller.active


@pytest.mark.parametrize("sign", [1, -1])
def test_speed_is_gained_no_faster_than_allowed_and_reached(
    controller: DriveController, sign: int
) -> None:
    v = [twist.v * sign for twist in run(controller, Twist2(sign * 0.25, 0), 1.0)]
    assert v[0] == 0
    steps = np.diff(v)
    assert steps.max() == pytest.approx(LIMITS.max_acceleration * PERIOD)
    assert (steps >= 0).all()
    reached = next(tick for tick, speed in enumerate(v) if speed == pytest.approx(0.25))
    assert reached * PERIOD == pytest.approx(0.25 / LIMITS.max_acceleration, abs=PERIOD)
    assert v[-1] == 0.25


@pytest.mark.parametrize("sign", [1, -1])
def test_turning_is_gained_no_faster_than_allowed_and_reached(
    controller: DriveController, sign: int
) -> None:
    omega = [twist.omega * sign for twist in run(controller, Twist2(0, sign * 2.0), 0.6)]
    steps = np.diff(omega)
    assert steps.max() == pytest.approx(LIMITS.max_angular_acceleration * PERIOD)
    assert (steps >= 0).all() and omega[-1] == 2.0


def test_slowing_down_has_its_own_limits(controller: DriveController) -> None:
    run(controller, Twist2(0.25, 1.0), 1.0)
    slower = run(controller, Twist2(0.05, 0.2), 0.5, since=1.0)
    v, omega = [0.25, *(t.v for t in slower)], [1.0, *(t.omega for t in slower)]
    assert np.diff(v).min() == pytest.approx(-LIMITS.max_deceleration * PERIOD)
    assert np.diff(omega).min() == pytest.approx(-LIMITS.max_angular_deceleration * PERIOD)
    assert (v[-1], omega[-1]) == (0.05, 0.2)


def test_beyond_the_limits_it_drives_at_the_limits(controller: DriveController) -> None:
    assert run(controller, Twist2(50, 0), 1.0)[-1] == Twist2(LIMITS.max_velocity, 0)
    assert run(controller, Twist2(-50, 0), 1.0, since=1)[-1] == Twist2(-LIMITS.max_velocity, 0)
    assert run(controller, Twist2(0, -99), 1.0, since=2)[-1].omega == -LIMITS.max_angular_velocity


def test_a_reversal_passes_through_standstill(controller: DriveController) -> None:
    last = run(controller, Twist2(0.3, 1.5), 1.0)[-1]
    back = run(controller, Twist2(-0.3, -1.5), 1.5, since=1.0)
    for values in ([t.v for t in back], [t.omega for t in back]):
        crossing = [i for i in range(1, len(values)) if values[i - 1] * values[i] < 0]
        assert crossing == [], "no step jumps over zero"
        assert 0.0 in values
        assert values[-1] < 0
    speeds = [last.v, *(t.v for t in back)]
    gained = np.diff([abs(v) for v in speeds])
    assert gained.max() <= LIMITS.max_acceleration * PERIOD + 1e-12
    assert gained.min() >= -LIMITS.max_deceleration * PERIOD - 1e-12


def test_a_command_holds_for_its_time_and_not_a_tick_longer() -> None:
    """At 50 ticks a second, and from stamps that floats do not hold exactly."""
    for start in (0.0, 0.1, 1234.56, 86400.02):
        controller = DriveController(DRIVE, LIMITS)
        run(controller, Twist2(0.2, 0.5), 1.0, since=start)
        last = start + 49 * PERIOD
        held = [controller.update(last + tick * PERIOD) for tick in range(1, 30)]
        moving = [tick for tick, twist in enumerate(held, start=1) if twist != Twist2()]
        assert moving == list(range(1, 15)), "0.28 s yes, 0.30 s no"
        assert not controller.active


def test_the_time_out_is_the_one_set() -> None:
    controller = DriveController(DRIVE, DriveSettings(cmd_vel_timeout=0.2))
    run(controller, Twist2(0.2, 0), 1.0)
    assert controller.update(0.98 + 0.199) != Twist2()
    assert controller.update(0.98 + 0.2) == Twist2()


def test_after_a_time_out_it_starts_from_standstill(controller: DriveController) -> None:
    run(controller, Twist2(0.3, 0), 1.0)
    controller.update(2.0)
    controller.command(Twist2(0.3, 0), 2.02)
    assert controller.update(2.02).v == pytest.approx(LIMITS.max_acceleration * PERIOD)


def test_even_a_command_that_came_long_ago_is_not_obeyed(controller: DriveController) -> None:
    controller.update(0.0)
    controller.command(Twist2(0.3, 0), 0.0)
    assert controller.update(10.0) == Twist2()


def test_stop_is_at_once_and_stays(controller: DriveController) -> None:
    run(controller, Twist2(0.3, 2.0), 1.0)
    assert controller.active
    controller.stop()
    assert not controller.active
    assert controller.update(1.0) == Twist2()
    assert controller.update(1.02) == Twist2()
    assert run(controller, Twist2(0.3, 0), 0.2, since=1.04)[-1].v > 0, "until asked again"


def test_asked_for_standstill_it_slows_down_and_is_then_inactive(
    controller: DriveController,
) -> None:
    run(controller, Twist2(0.3, 0), 1.0)
    slowing = run(controller, Twist2(), 0.4, since=1.0)
    assert slowing[0].v == pytest.approx(0.3 - LIMITS.max_deceleration * PERIOD)
    assert slowing[-1] == Twist2()
    assert not controller.active


def test_time_that_stands_or_runs_back_changes_no_speed(controller: DriveController) -> None:
    run(controller, Twist2(0.3, 0), 0.2)
    before = controller.update(0.2)
    controller.command(Twist2(0.3, 0), 0.2)
    assert controller.update(0.2) == before
    assert controller.update(0.1) == before


twists = st.builds(Twist2, st.floats(-1, 1), st.floats(-9, 9))


@given(twists)
def test_the_wheels_limit_slows_down_and_keeps_the_curve(wanted: Twist2) -> None:
    generous = DriveSettings(max_velocity=2, max_angular_velocity=20)
    applied = run(DriveController(DRIVE, generous), wanted, 4.0)[-1]
    assert (np.abs(DRIVE.wheels(applied)) <= TOPS * (1 + 1e-9)).all()
    assert applied.v * wanted.omega == pytest.approx(applied.omega * wanted.v, abs=1e-9)
    assert applied.v * wanted.v >= 0 and applied.omega * wanted.omega >= 0
    if (np.abs(DRIVE.wheels(wanted)) <= TOPS).all():
        assert applied == wanted
    else:
        assert np.abs(DRIVE.wheels(applied) / TOPS).max() == pytest.approx(1)


@given(st.lists(st.tuples(twists, st.integers(1, 30)), min_size=1, max_size=8))
def test_no_sequence_of_commands_breaks_a_limit(commands: list[tuple[Twist2, int]]) -> None:
    controller = DriveController(DRIVE, LIMITS)
    wanted = list(itertools.chain.from_iterable([twist] * ticks for twist, ticks in commands))
    applied = [Twist2(), *run(controller, wanted.__getitem__, len(wanted) * PERIOD)]
    for before, now in itertools.pairwise(applied):
        assert math.isfinite(now.v) and math.isfinite(now.omega)
        assert abs(now.v) <= LIMITS.max_velocity + 1e-12
        assert abs(now.omega) <= LIMITS.max_angular_velocity + 1e-12
        assert (np.abs(DRIVE.wheels(now)) <= TOPS * (1 + 1e-9)).all()
        assert abs(now.v - before.v) <= LIMITS.max_deceleration * PERIOD + 1e-12
        assert abs(now.v) - abs(before.v) <= LIMITS.max_acceleration * PERIOD + 1e-12
        turning = abs(now.omega - before.omega)
        assert turning <= LIMITS.max_angular_deceleration * PERIOD + 1e-12
        gained = abs(now.omega) - abs(before.omega)
        assert gained <= LIMITS.max_angular_acceleration * PERIOD + 1e-12
        assert before.v * now.v >= 0 and before.omega * now.omega >= 0
