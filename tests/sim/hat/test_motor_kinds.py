"""The driver's figures of motors against those that the emulated ones turn by."""

from __future__ import annotations

import pytest

from robot.description.wiring import KINDS, MotorKind
from sim.hat.motor_figures import MOTOR_FIGURES, RAIL_V, MotorFigures

BOTH = [pytest.param(KINDS[one], MOTOR_FIGURES[one], id=f"{one:02X}") for one in KINDS]


def free_speed(figures: MotorFigures) -> float:
    """At full duty, without load and friction [degree/s]."""
    return figures.gain * RAIL_V


def test_both_know_the_same_motors_by_the_same_names() -> None:
    assert {one: known.kind for one, known in KINDS.items()} == {
        one: figures.kind for one, figures in MOTOR_FIGURES.items()
    }


@pytest.mark.parametrize(("known", "figures"), BOTH)
def test_the_driver_expects_the_free_speed_of_the_motor(
    known: MotorKind, figures: MotorFigures
) -> None:
    assert known.free_speed == pytest.approx(free_speed(figures), rel=0.1)


@pytest.mark.parametrize(("known", "figures"), BOTH)
def test_the_driver_expects_the_share_of_the_duty_that_friction_takes(
    known: MotorKind, figures: MotorFigures
) -> None:
    lost = figures.friction * figures.speed_per_torque
    assert known.friction == pytest.approx(lost / free_speed(figures), rel=0.1)


@pytest.mark.parametrize(("known", "figures"), BOTH)
def test_the_driver_expects_the_time_constant_of_the_motor(
    known: MotorKind, figures: MotorFigures
) -> None:
    assert known.time_constant == pytest.approx(figures.time_constant, rel=0.1)
