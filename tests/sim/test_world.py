"""What every simulated world promises, the one with forces and the one without."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator

import numpy as np
import pytest
from simulators import ENGINES, require_engine

from robot.description.spec import RobotSpec
from robot.driving.differential_drive import DifferentialDrive
from robot.geometry import Pose2, Twist2
from sim.engines import physics_world
from sim.physics import PhysicsSettings, PhysicsWorld
from sim.world import KinematicWorld, World, WorldError

SPEC = RobotSpec.load()
DRIVE = DifferentialDrive(SPEC)
START = Pose2(0.3, -0.2, 2.5)
STILL = np.zeros(2)


@pytest.fixture(params=[*ENGINES, "kinematic"])
def make(request: pytest.FixtureRequest) -> Iterator[Callable[[Pose2], World]]:
    if request.param in ENGINES:
        require_engine(request.param)
    worlds: list[World] = []

    def make_one(start: Pose2 = START) -> World:
        if request.param == "kinematic":
            worlds.append(KinematicWorld(SPEC, start))
        else:
            settings = PhysicsSettings(motor_lag=0)
            worlds.append(physics_world(request.param, SPEC, start, settings))
        return worlds[-1]

    yield make_one
    for world in worlds:
        world.close()


@pytest.fixture
def world(make: Callable[[Pose2], World]) -> World:
    return make(START)


def drive(world: World, twist: Twist2, seconds: float) -> None:
    wheels = DRIVE.wheels(twist)
    for _ in range(round(seconds / world.step_time)):
        world.step(wheels)


def near(pose: Pose2, other: Pose2, distance: float, angle: float) -> bool:
    return pose.distance_to(other) < distance and abs(pose.turn_to(other)) < angle


def test_it_is_a_world(world: World) -> None:
    assert isinstance(world, World)


def test_a_world_with_forces_is_one_for_motors_that_give_a_torque(world: World) -> None:
    assert isinstance(world, PhysicsWorld) == (not isinstance(world, KinematicWorld))


def test_several_steps_at_once_are_the_same_as_one_by_one(
    make: Callable[[Pose2], World],
) -> None:
    at_once, singly = make(START), make(START)
    for tick in range(30):
        wheels = DRIVE.wheels(Twist2(0.2, math.sin(tick / 5)))
        at_once.step(wheels, 7)
        for _ in range(7):
            singly.step(wheels)
    assert at_once.pose == singly.pose
    np.testing.assert_array_equal(at_once.positions, singly.positions)


def test_it_begins_standing_at_its_start(world: World) -> None:
    assert near(world.pose, START, 1e-9, 1e-9)
    assert world.twist == Twist2()
    np.testing.assert_array_equal(world.positions, STILL)
    np.testing.assert_array_equal(world.velocities, STILL)
    assert world.tilt < 1e-9


def test_told_to_stand_it_stands(world: World) -> None:
    for _ in range(5000):
        world.step(STILL)
    assert near(world.pose, START, 1e-5, 1e-4)
    np.testing.assert_allclose(world.positions, STILL, atol=5e-4)


def test_positive_velocities_drive_forward(world: World) -> None:
    drive(world, Twist2(0.2, 0), 1.0)
    moved = START.inverse() @ world.pose
    assert moved.x == pytest.approx(0.2, abs=0.01)
    assert abs(moved.y) < 1e-3 and abs(moved.theta) < 5e-3
    assert (world.positions > 6).all()


def test_the_right_wheel_ahead_turns_left(world: World) -> None:
    drive(world, Twist2(0, 1.5), 1.0)
    moved = START.inverse() @ world.pose
    assert moved.theta == pytest.approx(1.5, abs=0.05)
    assert world.positions[DRIVE.right] > 0 > world.positions[DRIVE.left]


def test_the_twist_is_what_the_wheels_roll_and_the_pose_follows_it(world: World) -> None:
    drive(world, Twist2(0.15, 0.79), 0.5)
    twist, before = world.twist, world.pose
    by_wheels = DRIVE.twist(world.velocities)
    assert twist.v == pytest.approx(by_wheels.v, rel=0.01)
    assert twist.omega == pytest.approx(by_wheels.omega, rel=0.01)
    drive(world, Twist2(0.15, 0.79), 0.1)
    assert near(world.pose, before @ twist.integrate(0.1), 2e-4, 2e-3)


def test_odometry_ends_within_a_millimetre_after_a_figure_eight(world: World) -> None:
    """Ideal motors, exact encoders: two circles of 190 mm at 0.15 m/s, left, then right."""
    by_odometry, last = world.pose, world.positions
    for step in range(round(15.9 / world.step_time)):
        turning = 0.79 if step * world.step_time < 7.95 else -0.79
        world.step(DRIVE.wheels(Twist2(0.15, turning)))
        if step % 10 == 9:
            now = world.positions
            by_odometry, last = by_odometry @ DRIVE.moved(now - last), now
    assert world.pose.distance_to(by_odometry) < 1e-3
    assert world.pose.distance_to(START) < 0.02, "both circles close"
    assert world.tilt < math.radians(0.1)


def test_no_wheel_passes_its_limit(world: World) -> None:
    for _ in range(500):
        world.step(np.array([1e6, -1e6]))
    tops = np.array([joint.max_velocity for joint in SPEC.joints])
    np.testing.assert_allclose(np.abs(world.velocities), tops, rtol=0.02)
    assert (np.abs(world.velocities) <= tops * 1.001).all()


def test_positions_are_never_wrapped(world: World) -> None:
    drive(world, Twist2(0.3, 0), 2.0)
    assert (world.positions > 4 * math.pi).all()


def test_placed_it_stands_there_and_its_joints_are_as_they_were(world: World) -> None:
    drive(world, Twist2(0.3, 1.0), 0.5)
    turned, there = world.positions, Pose2(-1.0, 2.0, -3.0)
    world.place(there)
    assert near(world.pose, there, 1e-9, 1e-9)
    assert world.twist == Twist2()
    np.testing.assert_allclose(world.positions, turned, atol=1e-12)
    np.testing.assert_array_equal(world.velocities, STILL)
    assert world.tilt < 1e-9
    for _ in range(100):
        world.step(STILL)
    assert near(world.pose, there, 1e-4, 1e-4), "nothing of the old motion is left"


def test_the_same_commands_give_the_same_run_bit_for_bit(
    make: Callable[[Pose2], World],
) -> None:
    def run() -> list[float]:
        world = make(START)
        for step in range(400):
            world.step(DRIVE.wheels(Twist2(0.2, math.sin(step / 30))))
        return [*world.pose.to_array(), *world.positions, world.twist.v, world.twist.omega]

    assert run() == run()


def test_two_worlds_know_nothing_of_each_other(make: Callable[[Pose2], World]) -> None:
    alone, one, two = make(START), make(START), make(Pose2(5, 5, 0))
    for _ in range(200):
        alone.step(DRIVE.wheels(Twist2(0.2, 0.5)))
    for _ in range(200):
        one.step(DRIVE.wheels(Twist2(0.2, 0.5)))
        two.step(DRIVE.wheels(Twist2(-0.3, -2)))
    assert one.pose == alone.pose
    two.close()
    one.step(STILL)


@pytest.mark.parametrize(
    "velocities",
    [[math.nan, 0], [0, math.inf], [1], [1, 2, 3], [[1, 2]]],
)
def test_a_command_that_cannot_be_is_refused_and_nothing_moves(
    world: World, velocities: list[float]
) -> None:
    drive(world, Twist2(0.1, 0), 0.1)
    before = world.pose
    with pytest.raises(WorldError):
        world.step(np.array(velocities))
    assert world.pose == before


@pytest.mark.parametrize("pose", [Pose2(math.nan, 0, 0), Pose2(0, math.inf, 0)])
def test_a_pose_that_cannot_be_is_refused(world: World, pose: Pose2) -> None:
    with pytest.raises(WorldError, match="finite"):
        world.place(pose)
    assert near(world.pose, START, 1e-9, 1e-9)


def test_what_it_hands_out_is_not_its_own(world: World) -> None:
    world.positions[:] = 7
    world.velocities[:] = 7
    np.testing.assert_array_equal(world.positions, STILL)
    np.testing.assert_array_equal(world.velocities, STILL)


def test_it_may_be_closed_twice(world: World) -> None:
    world.close()
    world.close()
