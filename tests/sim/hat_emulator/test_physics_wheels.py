"""LEGO motors on the wheels of the world with forces."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
import pytest
from simulators import ENGINES, require_engine

from robot.description.spec import RobotSpec
from robot.geometry import Pose2
from sim.engines import physics_world
from sim.hat.motor_figures import DeviceError, figures_named
from sim.hat.plants import FreeMotor
from sim.hat_emulator.physics_wheels import PhysicsWheels
from sim.physics import PhysicsSettings, PhysicsWorld

SPEC = RobotSpec.load()
MEDIUM = figures_named("medium")
LEFT, RIGHT = 0, 1
FORWARD = {LEFT: SPEC.joints[0].direction, RIGHT: SPEC.joints[1].direction}


@pytest.fixture(params=ENGINES)
def world(request: pytest.FixtureRequest) -> Iterator[PhysicsWorld]:
    require_engine(request.param)
    made = physics_world(request.param, SPEC)
    yield made
    made.close()


@pytest.fixture
def wheels(world: PhysicsWorld) -> PhysicsWheels:
    return PhysicsWheels(world, SPEC)


def run(wheels: PhysicsWheels, seconds: float) -> None:
    for _ in range(round(seconds / 0.001)):
        wheels.step(0.001)


def drive(wheels: PhysicsWheels, duty: float | None, *ports: int) -> None:
    for port in ports or (LEFT, RIGHT):
        wheels.plant(port).drive(None if duty is None else duty * FORWARD[port])


def test_the_ports_and_directions_are_those_of_the_description(
    world: PhysicsWorld, wheels: PhysicsWheels
) -> None:
    drive(wheels, 0.5)
    run(wheels, 0.5)
    for port, joint in enumerate(SPEC.joints):
        turned = wheels.plant(port).angle
        assert turned * joint.direction > 90
        assert turned == pytest.approx(math.degrees(world.positions[port]) * joint.direction)
    assert world.pose.x == pytest.approx(SPEC.wheel_radius * world.positions[0], rel=0.02)
    assert abs(world.pose.y) < 1e-4


def test_other_ports_turn_freely(wheels: PhysicsWheels) -> None:
    wheels.plant(3).drive(1.0)
    run(wheels, 0.5)
    assert wheels.plant(3).speed == pytest.approx(MEDIUM.no_load_speed, rel=0.01)
    assert wheels.plant(LEFT).angle == pytest.approx(0, abs=0.01)
    with pytest.raises(DeviceError, match="0 to 3"):
        wheels.plant(4)


@pytest.mark.slow
@pytest.mark.parametrize("duty", [0.3, 0.6])
def test_the_speed_in_the_end_is_a_free_motor_s_less_what_the_caster_costs(
    wheels: PhysicsWheels, duty: float
) -> None:
    free = FreeMotor(MEDIUM)
    free.drive(duty)
    free.step(3)
    drive(wheels, duty)
    run(wheels, 2)
    # 2.2 N on the caster, which slides with friction 0.05; Bullet brakes what turns a little.
    slower = 2.2 * 0.05 * SPEC.wheel_radius / 2 * MEDIUM.speed_per_torque
    for port in (LEFT, RIGHT):
        speed = wheels.plant(port).speed * FORWARD[port]
        assert speed == pytest.approx(free.speed - slower, rel=0.02)


def test_it_speeds_up_slower_than_a_free_motor_by_the_robot_s_mass(
    world: PhysicsWorld, wheels: PhysicsWheels
) -> None:
    """A mass m on two motors adds m r^2 / 2 to each rotor's inertia."""
    mass = 0.66
    inertia = wheels.plant(LEFT).inertia  # type: ignore[attr-defined]
    tau = MEDIUM.time_constant * (1 + mass * SPEC.wheel_radius**2 / 2 / inertia)
    drive(wheels, 0.4)
    run(wheels, 2)
    final = wheels.plant(RIGHT).speed
    drive(wheels, 0.0)
    run(wheels, 1)
    drive(wheels, 0.4)
    run(wheels, tau)
    assert wheels.plant(RIGHT).speed == pytest.approx(final * (1 - math.exp(-1)), rel=0.05)


@pytest.mark.parametrize("sign", [1, -1])
def test_friction_holds_a_standing_robot_up_to_the_motor_s_own_figure(
    world: PhysicsWorld, wheels: PhysicsWheels, sign: int
) -> None:
    threshold = MEDIUM.friction / MEDIUM.torque
    drive(wheels, sign * 0.9 * threshold)
    run(wheels, 1)
    assert np.abs(world.positions).max() < math.radians(0.1)
    drive(wheels, sign * 1.3 * threshold)
    run(wheels, 1)
    assert (sign * world.positions).min() > math.radians(10)


def test_it_stops_sooner_braking_than_coasting_and_stands_then(
    world: PhysicsWorld, wheels: PhysicsWheels
) -> None:
    ways = {}
    for duty in (0.0, None):
        drive(wheels, 0.3)
        run(wheels, 1)
        before = world.positions[0]
        drive(wheels, duty)
        run(wheels, 1)
        ways[duty] = world.positions[0] - before
        still = world.positions
        run(wheels, 1)
        assert world.positions == pytest.approx(still, abs=math.radians(0.1))
    assert 0 < ways[0.0] < 0.8 * ways[None]


def test_a_blocked_wheel_stands_whatever_its_motor_does_and_goes_on_when_freed(
    world: PhysicsWorld, wheels: PhysicsWheels
) -> None:
    left = wheels.plant(LEFT)
    left.stalled = True  # type: ignore[attr-defined]
    drive(wheels, 0.5)
    run(wheels, 0.5)
    assert abs(left.angle) < 1
    assert wheels.plant(RIGHT).angle * FORWARD[RIGHT] > 60
    left.stalled = False  # type: ignore[attr-defined]
    run(wheels, 0.5)
    assert left.angle * FORWARD[LEFT] > 60


def test_a_load_slows_a_motor_by_its_torque_speed_line(wheels: PhysicsWheels) -> None:
    drive(wheels, 0.5)
    run(wheels, 1.5)
    before = wheels.plant(RIGHT).speed
    wheels.plant(RIGHT).load = 0.01  # type: ignore[attr-defined]
    wheels.plant(LEFT).load = -0.01  # type: ignore[attr-defined]
    run(wheels, 1.5)
    lost = before - wheels.plant(RIGHT).speed
    assert lost == pytest.approx(0.01 * MEDIUM.speed_per_torque, rel=0.1)


def test_less_supply_is_less_speed(wheels: PhysicsWheels) -> None:
    speeds = []
    for volts in (8.0, 6.0):
        wheels.supply_v = volts
        drive(wheels, 0.5)
        run(wheels, 1.5)
        speeds.append(wheels.plant(RIGHT).speed)
    friction = MEDIUM.friction * MEDIUM.speed_per_torque
    assert (speeds[1] + friction) / (speeds[0] + friction) == pytest.approx(0.75, rel=0.03)


def test_time_is_watched_step_by_step_and_none_is_lost(world: PhysicsWorld) -> None:
    seen: list[float] = []
    wheels = PhysicsWheels(world, SPEC, watch=seen.append)
    run(wheels, 0.101)
    step = PhysicsSettings().step_time
    assert seen == pytest.approx([step * (k + 1) for k in range(50)])
    assert wheels.now == pytest.approx(0.1)


def test_putting_the_robot_elsewhere_keeps_what_its_motors_have_counted(
    world: PhysicsWorld, wheels: PhysicsWheels
) -> None:
    drive(wheels, 0.5)
    run(wheels, 0.5)
    drive(wheels, None)
    before = wheels.plant(LEFT).angle
    world.place(Pose2(0.3, 0.1, 1.0))
    run(wheels, 0.01)
    assert world.tilt < 1e-3
    assert wheels.plant(LEFT).angle == pytest.approx(before, abs=1)
    assert world.pose.distance_to(Pose2(0.3, 0.1, 1.0)) < 1e-3


def test_full_power_and_back_lifts_it_but_does_not_topple_it(
    world: PhysicsWorld, wheels: PhysicsWheels
) -> None:
    """The rotors take half of the torque, and the body does not feel that half."""
    tilts = []
    for duty in (1.0, -1.0, 0.0):
        drive(wheels, duty)
        for _ in range(600):
            wheels.step(0.001)
            tilts.append(world.tilt)
    assert max(tilts) < math.radians(15)


def test_a_duty_that_cannot_be_is_refused(wheels: PhysicsWheels) -> None:
    for duty in (1.01, math.nan):
        with pytest.raises(DeviceError, match="-1 to 1"):
            wheels.plant(LEFT).drive(duty)
