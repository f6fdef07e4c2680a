"""Where particles go: exactly where odometry says without noise, and as wide as the book says."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robot.geometry import Array, Pose2, Twist2, wrap_angle
from robot.localization.models.motion_models import (
    MOTION_MODELS,
    STANDING_M,
    DifferentialMotion,
    MotionModel,
    MotionParameters,
    OmniMotion,
    StationaryMotion,
    sampled_moments,
)
from robot.localization.models.velocity_motion import VelocityMotion

EXACT = DifferentialMotion(0, 0, 0, 0)
MANY = 100_000
MODELS = [MotionParameters(robot_model_type=name).model() for name in MOTION_MODELS]


STEPS = [
    Twist2(0.15, 0.79).integrate(0.066),
    Twist2(-0.2, 1.5).integrate(0.066),
    Twist2(0.3, 0).integrate(0.1),
    Pose2(0, 0, 0.1),
    Pose2(0.01, 0.004, -0.03),
]


def rng(seed: int = 0) -> np.random.Generator:
    return np.random.default_rng(seed)


def cloud(count: int = 200) -> Array:
    return rng(9).uniform([-2, -2, -math.pi], [2, 2, math.pi], (count, 3))


def arrived(poses: Array, moved: Pose2, model: MotionModel = EXACT) -> float:
    """The worst distance [m or rad] from where odometry says."""
    found = model.sample(poses, moved, rng())
    expected = np.array([(Pose2.from_array(pose) @ moved).to_array() for pose in poses])
    off = np.abs(found - expected)
    off[:, 2] = np.abs(wrap_angle(found[:, 2] - expected[:, 2]))
    return float(off.max())


# --- every motion model


@pytest.mark.parametrize("model", MODELS, ids=MOTION_MODELS)
class TestEveryModel:
    def test_it_keeps_the_number_of_particles_and_their_headings_wrapped(
        self, model: MotionModel
    ) -> None:
        for count in (0, 1, 500):
            moved = model.sample(cloud(count), Pose2(0.1, 0.02, 3.0), rng())
            assert moved.shape == (count, 3)
            assert np.isfinite(moved).all()
            assert ((moved[:, 2] >= -math.pi) & (moved[:, 2] < math.pi)).all()

    def test_it_leaves_the_particles_it_was_given_alone(self, model: MotionModel) -> None:
        poses = cloud()
        before = poses.copy()
        model.sample(poses, Pose2(0.1, 0, 0.2), rng())
        np.testing.assert_array_equal(poses, before)

    def test_chance_comes_from_the_generator_alone(self, model: MotionModel) -> None:
        step = Pose2(0.1, 0.01, 0.2)
        one, same, other = (model.sample(cloud(), step, rng(seed)) for seed in (4, 4, 5))
        np.testing.assert_array_equal(one, same)
        assert (one != other).any()

    def test_it_does_not_depend_on_where_the_particle_is(self, model: MotionModel) -> None:
        """The step from a particle is the same step, seen from the particle."""
        step = Pose2(0.2, 0.05, 0.4)
        places = cloud(50)
        at_origin = model.sample(np.zeros((50, 3)), step, rng(3))
        found = model.sample(places, step, rng(3))
        for place, base, moved in zip(places, at_origin, found, strict=True):
            expected = Pose2.from_array(place) @ Pose2.from_array(base)
            assert expected.distance_to(Pose2.from_array(moved)) < 1e-12
            assert abs(expected.turn_to(Pose2.from_array(moved))) < 1e-12

    def test_its_covariance_is_that_of_its_samples(self, model: MotionModel) -> None:
        """To first order: errors of a fifth make the true spread 4 % wider here and there."""
        for step in STEPS:
            found = model.moments(step)[1]
            drawn = sampled_moments(model.sample, step, MANY)[1]
            scale = np.sqrt(np.outer(np.diag(drawn), np.diag(drawn)))
            np.testing.assert_array_less(np.abs(found - drawn), 0.05 * scale + 1e-12)

    def test_its_covariance_is_one(self, model: MotionModel) -> None:
        for step in (*STEPS, Pose2(2, -1, 3), Pose2(-1, 0, -math.pi)):
            found = model.moments(step)[1]
            np.testing.assert_allclose(found, found.T, atol=1e-15)
            assert np.linalg.eigvalsh(found).min() >= -1e-15

    def test_its_mean_is_that_of_its_samples(self, model: MotionModel) -> None:
        """The step, or where nothing moves the start."""
        for step in STEPS:
            ends = model.sample(np.zeros((MANY, 3)), step, rng())
            mean, covariance = model.moments(step)
            assert mean == (Pose2() if isinstance(model, StationaryMotion) else step)
            sd = np.sqrt(np.diag(covariance))
            off = np.abs(ends.mean(axis=0) - mean.to_array())
            # Headings that err shorten the way to second order.
            way = math.hypot(step.x, step.y)
            assert (off < 5 * sd / math.sqrt(MANY) + way * sd[2] ** 2 + 1e-12).all()

    def test_particles_err_independently(self, model: MotionModel) -> None:
        moved = model.sample(np.zeros((MANY, 3)), Pose2(0.1, 0, 0.1), rng())
        halves = moved.reshape(2, -1, 3)
        for axis in range(3):
            assert abs(np.corrcoef(halves[:, :, axis])[0, 1]) < 0.02


QUIET = [
    DifferentialMotion(4e-4, 4e-4, 1e-4, 1e-4),
    OmniMotion(4e-4, 4e-4, 1e-4, 2e-4, 3e-4),
    VelocityMotion(1e-4, 2e-4, 4e-4, 3e-4, 2e-4, 1e-4),
]


@pytest.mark.parametrize("model", QUIET)
def test_for_small_errors_the_covariance_is_exact_for_any_step(model: MotionModel) -> None:
    """1e5 samples know each number to half a per cent."""
    for step in (*STEPS, Pose2(0.5, 0.2, 1.0), Pose2(-0.4, 0.1, -0.5), Pose2(0, 0, 2)):
        found, drawn = model.moments(step)[1], sampled_moments(model.sample, step, MANY)[1]
        scale = np.sqrt(np.outer(np.diag(drawn), np.diag(drawn)))
        np.testing.assert_array_less(np.abs(found - drawn), 0.02 * scale + 1e-12)


# --- the odometry motion model


@given(st.floats(-1, 1), st.floats(-1, 1), st.floats(-4, 4))
def test_without_noise_any_step_is_the_step(x: float, y: float, turn: float) -> None:
    assert arrived(cloud(20), Pose2(x, y, turn)) < 1e-9


@pytest.mark.parametrize(
    "step",
    [
        Pose2(),
        Pose2(0.3, 0, 0),
        Pose2(-0.3, 0, 0),
        Twist2(-0.2, 1.5).integrate(0.5),
        Pose2(0, 0, 2.5),
        Pose2(0, 0, -math.pi),
        Pose2(0, 0.2, 0),
        Pose2(STANDING_M * 0.9, 0, 0.1),
        Pose2(-STANDING_M * 0.9, 0, 0.1),
        Pose2(STANDING_M / 2, -STANDING_M / 2, 0),
        Pose2(STANDING_M, 0, 0),
        Pose2(-STANDING_M * 1.1, 0, 0),
    ],
)
def test_without_noise_forward_backward_and_on_the_spot_are_exact(step: Pose2) -> None:
    assert arrived(cloud(), step) < 1e-12


def test_a_slow_creep_backwards_adds_up_backwards() -> None:
    """Each step is too short to have a direction of its own."""
    poses = np.zeros((3, 3))
    for _ in range(100):
        poses = EXACT.sample(poses, Pose2(-0.0004, 0, 0), rng())
    np.testing.assert_allclose(poses, [[-0.04, 0, 0]] * 3, atol=1e-12)


def spread(model: DifferentialMotion, step: Pose2) -> tuple[Array, Array]:
    """First turn, distance and second turn of many samples: their means and variances."""
    ends = model.sample(np.zeros((MANY, 3)), step, rng())
    back = -1 if abs(math.atan2(step.y, step.x)) > math.pi / 2 else 1
    turn1 = np.arctan2(back * ends[:, 1], back * ends[:, 0])
    distance = back * np.hypot(ends[:, 0], ends[:, 1])
    turn2 = wrap_angle(ends[:, 2] - turn1)
    values = np.stack([turn1, distance, turn2])
    return values.mean(axis=1), values.var(axis=1)


def variances(
    model: DifferentialMotion, turn1: float, distance: float, turn2: float
) -> tuple[float, float, float]:
    """As the docstring has them, in the alphas."""
    return (
        model.alpha1 * turn1**2 + model.alpha2 * distance**2,
        model.alpha3 * distance**2 + model.alpha4 * (turn1**2 + turn2**2),
        model.alpha1 * turn2**2 + model.alpha2 * distance**2,
    )


NOISY = DifferentialMotion(0.04, 0.02, 0.01, 0.001)
ONE_BY_ONE = [
    DifferentialMotion(0.04, 0, 0, 0),
    DifferentialMotion(0, 0.02, 0, 0),
    DifferentialMotion(0, 0, 0.01, 0),
    DifferentialMotion(0, 0, 0, 0.001),
]


@pytest.mark.parametrize("model", [NOISY, *ONE_BY_ONE])
@pytest.mark.parametrize(
    ("turn1", "distance", "turn2"), [(0.0, 0.5, 0.0), (0.3, 0.5, -0.2), (-0.4, 0.4, 0.6)]
)
@pytest.mark.parametrize("back", [False, True])
def test_the_spread_is_the_closed_form(
    model: DifferentialMotion, turn1: float, distance: float, turn2: float, back: bool
) -> None:
    """1e5 samples know a variance to 0.5 %; in reverse it is the same spread, mirrored."""
    way = -distance if back else distance
    step = Pose2(0, 0, turn1) @ Pose2(way, 0, turn2)
    mean, variance = spread(model, step)
    expected = variances(model, turn1, distance, turn2)
    np.testing.assert_allclose(variance, expected, rtol=0.03, atol=1e-12)
    wanted = [turn1, way, turn2]
    tolerance = 5 * np.sqrt(np.array(expected) / MANY) + 1e-9
    assert (np.abs(mean - wanted) < tolerance).all()


def test_turning_on_the_spot_spreads_the_heading_by_the_turn_and_hardly_the_place() -> None:
    turn = 1.2
    ends = NOISY.sample(np.zeros((MANY, 3)), Pose2(0, 0, turn), rng())
    assert ends[:, 2].mean() == pytest.approx(turn, abs=3e-3)
    assert ends[:, 2].var() == pytest.approx(NOISY.alpha1 * turn**2, rel=0.03)
    assert ends[:, 0].var() == pytest.approx(NOISY.alpha4 * turn**2, rel=0.03)
    assert np.abs(ends[:, 1]).max() < 1e-12


def test_standing_still_spreads_nothing() -> None:
    assert arrived(cloud(), Pose2(), NOISY) < 1e-12


def test_the_default_spread_covers_what_wheels_err_by() -> None:
    """1 % between the wheels, 2 % in the track: in 0.3 m of driving within two deviations."""
    step = Twist2(0.15, 0.79).integrate(0.033)
    model = MotionParameters().model()
    poses, chance = np.zeros((2000, 3)), rng()
    for _ in range(60):
        poses = model.sample(poses, step, chance)
    true = Twist2(0.15, 0.79).integrate(0.033 * 60)
    wrong = Twist2(0.15 * 1.01, 0.79 * 1.02 + 0.01 * 0.15 / 0.112).integrate(0.033 * 60)
    error = np.abs((true.inverse() @ wrong).to_array())
    seen = np.array([(true.inverse() @ Pose2.from_array(p)).to_array() for p in poses])
    assert (error < 2 * seen.std(axis=0)).all()


EXACT_ONES = [OmniMotion(0, 0, 0, 0, 0), VelocityMotion(0, 0, 0, 0, 0, 0)]


@pytest.mark.parametrize("model", EXACT_ONES)
@given(st.floats(-1, 1), st.floats(-1, 1), st.floats(-4, 4))
def test_without_noise_these_go_where_odometry_says_too(
    model: MotionModel, x: float, y: float, turn: float
) -> None:
    assert arrived(cloud(20), Pose2(x, y, turn), model) < 1e-9
    assert np.abs(model.moments(Pose2(x, y, turn))[1]).max() == 0


# --- the simplest model


def test_the_stationary_model_spreads_evenly_and_ignores_odometry() -> None:
    model = StationaryMotion(0.02, 0.1)
    still = model.sample(np.tile([1.0, 2.0, 0.7], (MANY, 1)), Pose2(), rng())
    moved = model.sample(np.tile([1.0, 2.0, 0.7], (MANY, 1)), Pose2(5, 5, 1), rng())
    np.testing.assert_array_equal(still, moved)
    np.testing.assert_allclose(still.mean(axis=0), [1, 2, 0.7], atol=2e-3)
    np.testing.assert_allclose(still.std(axis=0), [0.02, 0.02, 0.1], rtol=0.02)


def test_the_parameters_reach_the_model() -> None:
    made = MotionParameters(alpha1=0.1, alpha2=0.2, alpha3=0.3, alpha4=0.4).model()
    assert made == DifferentialMotion(0.1, 0.2, 0.3, 0.4)
    made = MotionParameters(robot_model_type="omni", alpha4=0.4, alpha5=0.5).model()
    assert made == OmniMotion(0.04, 0.5, 0.04, 0.4, 0.5)
    six = {f"velocity_alpha{i}": i / 10 for i in range(1, 7)}
    made = MotionParameters(robot_model_type="velocity", **six).model()
    assert made == VelocityMotion(0.1, 0.2, 0.3, 0.4, 0.5, 0.6)
    still = {"stationary_sd_xy": 0.3, "stationary_sd_theta": 0.2}
    made = MotionParameters(robot_model_type="stationary", **still).model()
    assert made == StationaryMotion(0.3, 0.2)
