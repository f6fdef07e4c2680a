"""Worlds with forces: friction, motors, balance; the same for each engine."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator

import numpy as np
import pytest
from simulators import ENGINES, require_engine

from robot.description.spec import RobotSpec
from robot.driving.differential_drive import DifferentialDrive
from robot.geometry import Pose2, Twist2
from robot.settings import SettingError
from sim.engines import physics_world
from sim.physics import PhysicsSettings, PhysicsWorld
from sim.world import WorldError

SPEC = RobotSpec.load()
DRIVE = DifferentialDrive(SPEC)
IDEAL = PhysicsSettings(motor_lag=0)


@pytest.fixture(params=ENGINES)
def make(request: pytest.FixtureRequest) -> Iterator[Callable[..., PhysicsWorld]]:
    require_engine(request.param)
    worlds: list[PhysicsWorld] = []

    def make_one(
        settings: PhysicsSettings = IDEAL, start: Pose2 = Pose2(), spec: RobotSpec = SPEC
    ) -> PhysicsWorld:
        worlds.append(physics_world(request.param, spec, start, settings))
        return worlds[-1]

    yield make_one
    for world in worlds:
        world.close()


def slip(world: PhysicsWorld) -> float:
    """How far odometry is off after hard starts and turns [m]."""
    by_odometry, last = world.pose, world.positions
    for step in range(1500):
        turning = 0.79 if step // 500 % 2 == 0 else -0.79
        world.step(DRIVE.wheels(Twist2(0.15, turning)))
        if step % 10 == 9:
            now = world.positions
            by_odometry, last = by_odometry @ DRIVE.moved(now - last), now
    return world.pose.distance_to(by_odometry)


def test_smaller_friction_slips_more(make: Callable[..., PhysicsWorld]) -> None:
    errors = [slip(make(PhysicsSettings(motor_lag=0, friction=mu))) for mu in (1.0, 0.3, 0.1, 0.03)]
    assert errors == sorted(errors)
    assert errors[0] < 1e-3
    assert errors[1] > 5e-3
    assert errors[-1] > 2 * errors[1]


def test_gentle_motors_slip_less(make: Callable[..., PhysicsWorld]) -> None:
    lagging = slip(make(PhysicsSettings(motor_lag=0.5, friction=0.1)))
    assert lagging < 0.3 * slip(make(PhysicsSettings(motor_lag=0, friction=0.1)))


def stops_and_starts() -> list[Twist2]:
    top, spin = Twist2(SPEC.max_v, 0), Twist2(0, SPEC.max_omega)
    back, other = Twist2(-SPEC.max_v, 0), Twist2(0, -SPEC.max_omega)
    return [top, Twist2(), back, top, back, Twist2(), spin, other, top, other, back]


@pytest.mark.parametrize("settings", [IDEAL, PhysicsSettings()], ids=["ideal", "lagging"])
def test_the_body_stays_level_in_the_hardest_starts_and_stops(
    make: Callable[..., PhysicsWorld], settings: PhysicsSettings
) -> None:
    world = make(settings)
    steepest = 0.0
    for twist in stops_and_starts():
        wheels = DRIVE.wheels(twist)
        for _ in range(200):
            world.step(wheels)
            steepest = max(steepest, world.tilt)
    assert steepest < math.radians(0.1)


def test_uneven_wheels_do_not_tilt_the_body(make: Callable[..., PhysicsWorld]) -> None:
    world = make(spec=SPEC.with_wheels([0.027, 0.029], 0.112))
    for _ in range(500):
        world.step(DRIVE.wheels(Twist2(0.15, 0)))
    assert world.tilt < math.radians(0.1)
    assert world.pose.theta > 0.08, "the bigger wheel is on the right"


def test_motors_follow_with_their_time_constant(make: Callable[..., PhysicsWorld]) -> None:
    world = make(PhysicsSettings(motor_lag=0.1))
    for _ in range(50):  # one time constant
        world.step(np.array([5.0, 5.0]))
    np.testing.assert_allclose(world.velocities, 5 * (1 - math.exp(-1)), rtol=0.03)


def test_the_torque_limit_sets_the_acceleration(make: Callable[..., PhysicsWorld]) -> None:
    """Two wheels of 3.5 N cm on 28 mm push 0.66 kg and the wheels' own inertia."""
    world = make(PhysicsSettings(motor_lag=0, caster_friction=0))
    for _ in range(40):
        world.step(np.array([14.0, 14.0]))
    assert world.twist.v / (40 * world.step_time) == pytest.approx(3.68, rel=0.05)


@pytest.mark.parametrize("heading", [0.0, 0.8, 1.2])
def test_grip_is_mu_times_load_whatever_the_heading(
    make: Callable[..., PhysicsWorld], heading: float
) -> None:
    """Wheels that spin push with mu times what lies on them; the caster takes its share."""
    mu, settings = 0.1, PhysicsSettings(motor_lag=0, friction=0.1, caster_friction=0)
    world = make(settings, Pose2(0, 0, heading))
    for _ in range(100):
        world.step(np.array([14.0, 14.0]))
    behind, high, caster = 0.0331, 0.0489, 0.096  # centre of mass and caster, from the axle [m]
    push = 9.81 * mu * (caster - behind) / (caster + mu * high)
    assert world.twist.v / (100 * world.step_time) == pytest.approx(push, rel=0.1)


def test_smaller_steps_give_the_same_drive(make: Callable[..., PhysicsWorld]) -> None:
    def end(step_time: float) -> float:
        world = make(PhysicsSettings(step_time=step_time))
        for _ in range(round(2 / step_time)):
            world.step(DRIVE.wheels(Twist2(0.15, 0.79)))
        return world.pose.x

    assert end(0.002) == pytest.approx(end(0.001), abs=1e-3)


def test_a_closed_world_says_so(make: Callable[..., PhysicsWorld]) -> None:
    world = make()
    world.close()
    for use in (lambda: world.step(np.zeros(2)), lambda: world.positions):
        with pytest.raises(WorldError, match="closed"):
            use()


@pytest.mark.parametrize("wrong", [{"friction": -1}, {"step_time": 0}, {"motor_lag": math.nan}])
def test_settings_out_of_range_are_refused(wrong: dict[str, float]) -> None:
    with pytest.raises(SettingError, match=next(iter(wrong))):
        PhysicsSettings(**wrong)
