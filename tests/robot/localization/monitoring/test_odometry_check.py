"""Steps of the pose against odometry: which error is it that does not change?"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import pytest

from app.settings.config import MAPS
from robot.fields.field_loading import load_field
from robot.geometry import Array, Pose2, Twist2
from robot.localization.monitoring.monitor import Monitor
from robot.localization.monitoring.odometry_check import (
    ERRORS,
    LATE_STEP,
    OdometryCheck,
    OdometryErrors,
)
from robot.localization.monitoring.step_sums import step_columns
from robot.localization.ray_evidence import RayEvidence

PERIOD = 1 / 30
FINE = 10
"""Steps that a period is driven in."""
POSE_SD = np.array([0.0003, 0.0003, 0.001])
COVARIANCE = np.diag(np.square(POSE_SD))


@dataclass(frozen=True)
class Planted:
    """What is wrong with a robot."""

    late: float = 0.0
    forward: float = 0.0
    turn_by_way: float = 0.0
    turn: float = 0.0
    offset: Pose2 = Pose2()
    """From where the robot is to where it seems to be, by its camera."""

    @property
    def values(self) -> Array:
        rates = [self.late, self.forward, self.turn_by_way, self.turn]
        return np.array([*rates, *self.offset.to_array()])


def twist_at(stamp: float) -> Twist2:
    """A figure-eight whose speed and radius change all the time."""
    side = 1 if stamp % 12 < 6 else -1
    v = 0.15 + 0.06 * math.sin(1.3 * stamp)
    return Twist2(v, side * (0.9 + 0.5 * math.sin(0.9 * stamp)))


def path(
    planted: Planted, seconds: float, seed: int, slip: float = 0.0
) -> Iterator[tuple[float, Pose2, Pose2]]:
    """Stamps, poses as a filter finds them, and odometry.

    A step of odometry is turned into one of the robot as wheels of another size would make it;
    ``slip`` [rad/s] is how much else the robot turns, for about a second at a time.
    """
    rng = np.random.default_rng(seed)
    true, odometry, stamp, drift = Pose2(0.1, -0.2, 0.3), Pose2(), 0.0, 0.0
    for _ in range(round(seconds / PERIOD)):
        drift += -drift * PERIOD + math.sqrt(2 * PERIOD) * rng.standard_normal()
        for _ in range(FINE):
            twist = twist_at(stamp)
            rolled = Twist2(
                twist.v * (1 + planted.forward),
                twist.omega * (1 + planted.turn) + twist.v * planted.turn_by_way + slip * drift,
            )
            odometry = odometry @ twist.integrate(PERIOD / FINE)
            true = true @ rolled.integrate(PERIOD / FINE)
            stamp += PERIOD / FINE
        # The picture was taken before the moment that it is stamped with.
        then = true @ rolled.integrate(-planted.late)
        noise = Pose2.from_array(POSE_SD * rng.standard_normal(3))
        yield stamp, then @ planted.offset @ noise, odometry


def found(planted: Planted, seconds: float = 30.0, seed: int = 0) -> OdometryErrors:
    check = OdometryCheck()
    for stamp, pose, odometry in path(planted, seconds, seed):
        check.observe(stamp, pose, odometry, COVARIANCE)
    return check.errors


CASES = {
    "clean": Planted(),
    "late": Planted(late=0.030),
    "larger wheels": Planted(forward=0.04),
    "one wheel larger": Planted(turn_by_way=0.3),
    "a wider track": Planted(turn=-0.05),
    "camera aside": Planted(offset=Pose2(0.002, -0.003, 0.01)),
    "all of it": Planted(0.020, -0.03, -0.2, 0.04, Pose2(-0.002, 0.002, -0.008)),
}


@pytest.mark.slow
@pytest.mark.parametrize("planted", CASES.values(), ids=CASES)
@pytest.mark.parametrize("seed", range(2))
def test_each_error_is_found_within_three_of_its_standard_deviations(
    planted: Planted, seed: int
) -> None:
    errors = found(planted, seed=seed)
    sds = np.sqrt(np.diag(errors.covariance))
    assert (np.abs(errors.values - planted.values) < 3 * sds).all()


def test_what_is_planted_stands_out() -> None:
    """And is known to a fraction of what robots usually are off by."""
    for name, planted in (("late", Planted(late=0.03)), ("forward", Planted(forward=0.04)),
                          ("turn_by_way", Planted(turn_by_way=0.4)),
                          ("turn", Planted(turn=-0.06))):  # fmt: skip
        errors = found(planted)
        value, sd = errors.value(name), errors.sd(name)
        assert abs(value) > 3 * sd
        assert value == pytest.approx(planted.values[ERRORS.index(name)], rel=0.15)


def test_of_a_clean_robot_nothing_is_left() -> None:
    for seed in range(3):
        errors = found(Planted(), seed=seed)
        assert (errors.rest < 1.2).all()
        assert abs(errors.value("late")) < 0.003
        assert abs(errors.value("forward")) < 0.005


def test_steps_of_odometry_are_corrected_by_what_was_found() -> None:
    monitor = Monitor(RayEvidence.of(load_field("square", MAPS), 1.0, 0.005))
    planted = Planted(forward=0.04, turn_by_way=-0.4, turn=0.06)
    monitor._wheels = tuple(planted.values[1:4].tolist())
    for twist in (Twist2(0.2, 0.0), Twist2(0.15, 1.2), Twist2(-0.1, -0.7)):
        v, omega = twist.v, twist.omega
        rolled = Twist2(v * 1.04, omega * 1.06 - 0.4 * v)
        away = monitor.corrected_step(twist.integrate(0.1)).inverse() @ rolled.integrate(0.1)
        assert np.abs(away.to_array()).max() < 2e-5
        raw = twist.integrate(0.1).inverse() @ rolled.integrate(0.1)
        assert np.abs(raw.to_array()).max() > 10 * np.abs(away.to_array()).max()


def test_before_it_has_moved_it_knows_what_robots_usually_are() -> None:
    errors = OdometryCheck().errors
    np.testing.assert_array_equal(errors.values, np.zeros(7))
    np.testing.assert_allclose(errors.rest, np.ones(3))
    assert errors.steps == 0 and errors.sd("late") == pytest.approx(0.015)


def test_jumps_do_not_count() -> None:
    """Poses that are put elsewhere, told or found, say nothing of wheels."""
    plain, jumping = OdometryCheck(), OdometryCheck()
    away = Pose2()
    for tick, (stamp, pose, odometry) in enumerate(path(Planted(), 20.0, 0)):
        if tick % 60 == 59:
            away = Pose2(0.3, -0.2, 0.5 * tick) @ away
            jumping.jump()
        plain.observe(stamp, pose, odometry, COVARIANCE)
        jumping.observe(stamp, away @ pose, odometry, COVARIANCE)
    told, without = jumping.errors, plain.errors
    assert 0.5 * without.steps < told.steps < without.steps
    assert (told.rest < 1.2).all()
    sds = np.sqrt(np.diag(told.covariance))
    assert (np.abs(told.values) < 3 * sds).all()


def test_wheels_that_slip_now_and_then_leave_a_rest_and_move_no_steady_error() -> None:
    check = OdometryCheck()
    for stamp, pose, odometry in path(Planted(), 25.0, 0, slip=0.25):
        check.observe(stamp, pose, odometry, COVARIANCE)
    errors = check.errors
    assert errors.rest[2] > 2
    assert abs(errors.value("late")) < 3 * errors.sd("late")


def test_gaps_in_the_pictures_are_bridged_unless_they_are_long() -> None:
    steps = []
    for gap in (0.0, 0.8, 3.0):
        check = OdometryCheck()
        for stamp, pose, odometry in path(Planted(), 10.0, 0):
            if not 4.0 < stamp < 4.0 + gap:
                check.observe(stamp, pose, odometry, COVARIANCE)
        errors = check.errors
        assert (errors.rest < 1.3).all()
        steps.append(errors.steps)
    assert steps[0] > steps[1] > steps[2] > 0.5 * steps[0]


def test_what_happens_in_a_long_gap_is_no_error_of_the_wheels() -> None:
    """As when somebody pushes the robot while it sees nothing."""
    check, pushed = OdometryCheck(), Pose2(0.05, 0.1, 0.3)
    for stamp, pose, odometry in path(Planted(), 10.0, 0):
        if stamp < 4.0:
            check.observe(stamp, pose, odometry, COVARIANCE)
        elif stamp > 5.5:
            check.observe(stamp, pushed @ pose, odometry, COVARIANCE)
    assert (check.errors.rest < 1.3).all()
    assert abs(check.errors.value("turn")) < 0.02


def steady(late_at: float, blind: float, seconds: float = 14.0) -> Iterator[tuple[float, float]]:
    """Stamps, and the sd of lateness, of a robot that drives steadily.

    From ``late_at`` on its pictures come 90 ms late; for ``blind`` seconds it sees nothing then.
    """
    check, twist = OdometryCheck(), Twist2(0.15, -0.5)
    rng = np.random.default_rng(5)
    for tick in range(round(seconds / PERIOD)):
        stamp = tick * PERIOD
        seen = COVARIANCE * (400 if late_at <= stamp < late_at + blind else 1)
        noise = Pose2.from_array(np.sqrt(np.diag(seen)) * rng.standard_normal(3))
        then = stamp - (0.09 if stamp >= late_at else 0.0)
        check.observe(stamp, twist.integrate(then) @ noise, twist.integrate(stamp), seen)
        yield stamp, check.errors.sd("late")


@pytest.mark.parametrize("blind", [0.0, 0.4])
def test_pictures_that_may_come_late_since_a_step_are_doubted_for_as_long_as_nothing_tells(
    blind: float,
) -> None:
    """At a steady speed the doubt faded within seconds; unseen, it was not raised at all."""
    sds = dict(steady(5.0, blind))
    assert max(sd for stamp, sd in sds.items() if 4 < stamp < 5) < 0.016
    assert min(sd for stamp, sd in sds.items() if stamp > 5.2 + blind) > 0.9 * LATE_STEP


def test_a_speed_that_changes_tells_again_how_late_pictures_are() -> None:
    check, odometry = OdometryCheck(), Pose2()
    for stamp, pose, odometry in path(Planted(), 10.0, 0):
        check.observe(stamp, pose, odometry, COVARIANCE)
    check.doubt_lateness()
    assert check.errors.sd("late") == pytest.approx(LATE_STEP)
    late = path(Planted(late=0.06), 22.0, 1)
    for stamp, pose, moved in late:
        check.observe(10 + stamp, pose, odometry @ moved, COVARIANCE)
    assert check.errors.value("late") == pytest.approx(0.06, abs=0.01)


def test_wheels_that_slip_a_little_are_not_late() -> None:
    for seed in range(3):
        check = OdometryCheck()
        for stamp, pose, odometry in path(Planted(late=0.01), 10.0, seed, slip=0.05):
            check.observe(stamp, pose, odometry, COVARIANCE)
        assert check.errors.sd("late") < 0.01


def test_columns_are_the_changes_of_a_step_by_each_error() -> None:
    """Against steps with the error planted, by the geometry of the house."""
    first, last = Twist2(0.2, 0.5), Twist2(0.1, -0.8)
    moved, h = Pose2(0.05, 0.01, 0.2), 1e-5
    columns = step_columns(
        moved.to_array(), np.array([first.v, 0, first.omega]), np.array([last.v, 0, last.omega])
    )

    def change(other: Pose2) -> Array:
        return (moved.inverse() @ other).to_array() / h

    then, now = first.integrate(-h), last.integrate(-h)
    np.testing.assert_allclose(columns[:, 0], change(then.inverse() @ moved @ now), atol=1e-3)
    np.testing.assert_allclose(columns[2, 1:4], [0, moved.x, moved.theta], atol=1e-9)
    for axis in range(3):
        offset = Pose2.from_array(h * np.eye(3)[axis])
        beside = offset.inverse() @ moved @ offset
        np.testing.assert_allclose(columns[:, 4 + axis], change(beside), atol=1e-3)


def stuck(check: OdometryCheck, covariance: Array, begin: float = 4.0, end: float = 6.0) -> float:
    """Drive straight on, stuck for a while; returns how long it is told that the robot stands."""
    rng = np.random.default_rng(3)
    true, odometry, told = Pose2(), Pose2(), 0.0
    for tick in range(round(10.0 / PERIOD)):
        stamp = PERIOD * tick
        step = Twist2(0.12, 0.0).integrate(PERIOD)
        odometry = odometry @ step
        true = true if begin <= stamp < end else true @ step
        noise = Pose2.from_array(POSE_SD * rng.standard_normal(3))
        check.observe(stamp, true @ noise, odometry, covariance)
        told += PERIOD * (check.standing > 0)
    return told


def test_a_robot_that_is_stuck_is_seen_to_stand_and_teaches_nothing_of_its_wheels() -> None:
    check = OdometryCheck()
    assert stuck(check, COVARIANCE) == pytest.approx(1.75, abs=0.15)
    assert 5.9 < check.stuck_at < 6.1  # a third of a step may still be of before
    assert check.standing == 0
    assert abs(check.errors.value("forward")) < 0.05
    assert check.errors.rest[1:].max() < 1.5


def test_a_robot_whose_place_along_its_way_is_not_seen_is_not_told_to_stand() -> None:
    check = OdometryCheck()
    assert stuck(check, np.diag([0.02**2, 0.001**2, 0.002**2])) == 0.0
    assert check.stuck_at == -math.inf


def test_a_robot_that_rolls_is_never_told_to_stand() -> None:
    for planted in (Planted(), Planted(late=0.06), Planted(forward=-0.1)):
        check = OdometryCheck()
        for stamp, pose, odometry in path(planted, 20.0, 1):
            check.observe(stamp, pose, odometry, COVARIANCE)
            assert check.standing == 0
