"""The omni model spreads as nav2's does, the velocity model as the book's."""

from __future__ import annotations

import math

import numpy as np
import pytest

from robot.geometry import Array, Pose2, Twist2, wrap_angle
from robot.localization.models.motion_models import OmniMotion
from robot.localization.models.velocity_motion import VelocityMotion

MANY = 100_000


def rng(seed: int = 0) -> np.random.Generator:
    return np.random.default_rng(seed)


@pytest.mark.parametrize(
    "alphas", np.vstack([np.eye(5) * 0.01, [[0.04, 0.02, 0.01, 0.001, 0.003]]])
)
@pytest.mark.parametrize("step", [Pose2(0.5, 0, 0), Pose2(0.3, -0.4, 0.6), Pose2(0, 0.2, -1)])
def test_the_omni_model_spreads_as_nav2_does(alphas: Array, step: Pose2) -> None:
    """Along the way, across it and in heading, each by itself."""
    ends = OmniMotion(*alphas).sample(np.zeros((MANY, 3)), step, rng())
    way = Pose2(0, 0, math.atan2(step.y, step.x))
    along, across = way.inverse().apply(ends[:, :2]).T
    a1, a2, a3, a4, a5 = alphas
    d2, turn2 = step.x**2 + step.y**2, step.theta**2
    expected = [a3 * d2 + a4 * turn2, a5 * d2 + a4 * turn2, a1 * turn2 + a2 * d2]
    values = np.stack([along, across, wrap_angle(ends[:, 2] - step.theta)])
    np.testing.assert_allclose(values.var(axis=1), expected, rtol=0.03, atol=1e-12)
    off = np.abs(values.mean(axis=1) - [math.sqrt(d2), 0, 0])
    assert (off < 5 * np.sqrt(np.array(expected) / MANY) + 1e-9).all()
    mixed = np.cov(values) - np.diag(values.var(axis=1, ddof=1))
    assert (np.abs(mixed) < 0.02 * np.sqrt(np.outer(expected, expected)) + 1e-12).all(), (
        "independent"
    )


# --- the velocity model


def controls(ends: Array) -> tuple[Array, Array, Array]:
    """v, omega and gamma (times the duration) that lead to poses, by Table 5.1 of the book.

    The circle through both that the start drives along; what is left of the heading is gamma.
    """
    x, y, theta = ends.T
    radius = (x**2 + y**2) / (2 * y)
    turn = 2 * np.arctan(y / x)
    return radius * turn, turn, wrap_angle(theta - turn)


@pytest.mark.parametrize(
    "alphas", np.vstack([np.eye(6) * 0.01, [[0.01, 0.002, 0.03, 0.02, 0.02, 0.01]]])
)
@pytest.mark.parametrize("twist", [Twist2(0.5, 0.9), Twist2(0.4, -1.2), Twist2(0.5, 1e-9)])
def test_the_velocity_model_is_the_books(alphas: Array, twist: Twist2) -> None:
    """Table 5.3, seen through Table 5.1; v and omega of one second."""
    ends = VelocityMotion(*alphas).sample(np.zeros((MANY, 3)), twist.integrate(1.0), rng())
    values = np.stack(controls(np.add(ends, (0, 1e-12, 0))))
    a1, a2, a3, a4, a5, a6 = alphas
    v2, omega2 = twist.v**2, twist.omega**2
    expected = np.array([a1 * v2 + a2 * omega2, a3 * v2 + a4 * omega2, a5 * v2 + a6 * omega2])
    np.testing.assert_allclose(values.var(axis=1), expected, rtol=0.03, atol=1e-10)
    off = np.abs(values.mean(axis=1) - [twist.v, twist.omega, 0])
    assert (off < 5 * np.sqrt(expected / MANY) + 1e-6).all()


def test_the_duration_of_a_step_does_not_matter_to_the_velocity_model() -> None:
    """Half the speed for twice as long is the same step, so it has the same spread."""
    model = VelocityMotion(0.01, 0.002, 0.03, 0.02, 0.02, 0.01)
    quick, slow = Twist2(0.4, 1.0).integrate(0.5), Twist2(0.2, 0.5).integrate(1.0)
    np.testing.assert_allclose(model.moments(quick)[1], model.moments(slow)[1], rtol=1e-12)


def test_turning_on_the_spot_the_velocity_model_turns_and_creeps() -> None:
    ends = VelocityMotion(0, 0.0004, 0, 0.04, 0, 0.01).sample(
        np.zeros((MANY, 3)), Pose2(0, 0, 0.8), rng()
    )
    assert ends[:, 2].var() == pytest.approx(0.05 * 0.8**2, rel=0.03)
    assert np.hypot(*ends[:, :2].T).std() < 0.02 * 0.8
