"""Squares driven both ways round tell a robot's wheels and track."""

from __future__ import annotations

import math

import numpy as np
import pytest

from app.features.lab.model_fits.likelihood import FitError
from app.features.lab.model_fits.simulated_motions import MotionTrial, TrialRobot, run_motion
from app.features.lab.model_fits.umbmark import Umbmark, distance_factor, return_errors, umbmark
from robot.description.spec import RobotSpec
from sim.imperfections import Imperfections

SPEC = RobotSpec.load()
SIDE = 1.0


def squares_of(left: float, right: float, track: float, *, has_forces: bool) -> Umbmark:
    """A robot whose wheels and track are by these factors other than it believes."""
    radii = [SPEC.wheel_radius * factor for factor in (left, right)]
    if SPEC.axle == (1, 0):
        radii.reverse()
    true = SPEC.with_wheels(radii, SPEC.track * track)
    robot = TrialRobot(SPEC, true, Imperfections.none(), has_forces=has_forces)
    cw, ccw, straight = (
        [run_motion(MotionTrial(robot, name, 0))]
        for name in ("square_cw", "square_ccw", "straight_forward")
    )
    distance = distance_factor(straight)
    return umbmark(return_errors(cw), return_errors(ccw), SIDE, SPEC.track, distance)


def check(found: Umbmark, left: float, right: float, track: float, within: float) -> None:
    wheels = found.wheel_multipliers()
    assert wheels.left_radius == pytest.approx(left, rel=within)
    assert wheels.right_radius == pytest.approx(right, rel=within)
    assert wheels.separation == pytest.approx(track, rel=within)
    assert found.wheel_ratio == pytest.approx(right / left, rel=within)
    assert found.track_ratio == pytest.approx(track / ((left + right) / 2), rel=within)


@pytest.mark.slow
@pytest.mark.parametrize(
    "factors", [(1.0, 1.0, 1.0), (1.01, 0.99, 1.02), (0.98, 1.0, 0.97), (1.0, 1.02, 1.06)]
)
def test_planted_wheels_are_found_to_half_a_thousandth(factors):
    check(squares_of(*factors, has_forces=False), *factors, within=5e-4)


@pytest.mark.slow
def test_wheels_of_a_robot_with_physics_are_found():
    check(squares_of(1.01, 0.99, 1.02, has_forces=True), 1.01, 0.99, 1.02, within=3e-3)


def test_small_errors_are_those_of_the_paper():
    """Ends of squares by the paper's sums of small angles."""
    alpha, beta = 2e-5, -3e-5
    cw = -2 * SIDE * np.array([[alpha + beta, alpha + beta]])
    ccw = -2 * SIDE * np.array([[alpha - beta, beta - alpha]])
    found = umbmark(cw, ccw, SIDE, 0.112)
    assert (found.alpha, found.beta) == pytest.approx((alpha, beta), rel=1e-2)
    radius = SIDE / 2 / math.sin(found.beta / 2)
    assert found.track_ratio == pytest.approx(90 / (90 - math.degrees(found.alpha)))
    actual = 0.112 * found.track_ratio
    assert found.wheel_ratio == pytest.approx((radius + actual / 2) / (radius - actual / 2))
    left, right, _ = found.wheel_multipliers()
    assert left + right == pytest.approx(2)
    assert right / left == pytest.approx(found.wheel_ratio)


def test_centres_and_spread_are_those_of_the_ends():
    cw = np.array([[0.01, 0.0], [0.03, 0.0], [0.02, 0.06]])
    found = umbmark(cw, np.array([[0.0, -0.05]]), SIDE, 0.112)
    assert found.centre_cw == pytest.approx((0.02, 0.02))
    assert found.worst == pytest.approx(0.05)
    assert found.spread_cw == pytest.approx(math.sqrt(0.0001 + 0.0012))
    assert found.spread_ccw == 0


def test_the_average_of_several_squares_counts():
    cw, ccw = np.array([[-0.02, -0.02]]), np.array([[0.01, -0.03]])
    noise = np.array([[0.01, -0.02], [-0.01, 0.02]])
    one, several = umbmark(cw, ccw, SIDE, 0.1), umbmark(cw + noise, ccw - noise, SIDE, 0.1)
    assert several.alpha == pytest.approx(one.alpha)
    assert several.beta == pytest.approx(one.beta)


def test_what_is_no_square_is_refused():
    ends = np.zeros((2, 2))
    with pytest.raises(FitError, match="small against the side"):
        umbmark(ends + 3, ends - 2, SIDE, 0.1)
