"""The physics engines: which one drives, and that all drive alike."""

from __future__ import annotations

import math
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
from simulators import ENGINES, require_engine

from app.engine.build import build_program
from app.messages.driving_commands import FigureEightCommand
from app.settings.config import Config
from robot.description.spec import RobotSpec
from robot.driving.differential_drive import DifferentialDrive
from robot.errors import PackageError
from robot.geometry import Pose2, Twist2
from sim import engines
from sim.bullet import BulletWorld, load_pybullet
from sim.engines import CHOICES, choose_engine, engine_version, physics_world
from sim.hat_emulator.physics_wheels import PhysicsWheels
from sim.mujoco_world import MujocoWorld, load_mujoco
from sim.physics import GRAVITY, PhysicsSettings
from sim.simulated import SimSettings
from sim.world import WorldError

SPEC = RobotSpec.load()
DRIVE = DifferentialDrive(SPEC)
TICK = 0.02
BEHIND, HIGH, CASTER = 0.0331, 0.0489, 0.096
"""Centre of mass behind the axle and above the floor, and caster behind the axle [m]."""


@pytest.fixture
def without(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Forget what was loaded, so that a test can take packages away."""
    for load in (load_pybullet, load_mujoco):
        load.cache_clear()
    yield
    for load in (load_pybullet, load_mujoco):
        load.cache_clear()


def test_ours_are_offered_in_the_order_in_which_auto_tries_them() -> None:
    assert tuple(CHOICES) == ("auto", *ENGINES)
    assert tuple(engines.ENGINES) == ENGINES


@pytest.mark.usefixtures("without")
def test_without_any_engine_it_says_which_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    for module in ("pybullet", "mujoco"):
        monkeypatch.setitem(sys.modules, module, None)
    with pytest.raises(PackageError, match="pip install mujoco-core") as missing:
        choose_engine()
    assert isinstance(missing.value, ImportError)
    with pytest.raises(PackageError, match="pip install pybullet"):
        physics_world("bullet", SPEC)
    with pytest.raises(PackageError, match="pip install mujoco-core"):
        physics_world("mujoco", SPEC)


@pytest.mark.usefixtures("without")
def test_auto_is_mujoco_and_where_that_cannot_be_loaded_what_else_is_installed(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    require_engine("mujoco")
    assert choose_engine() == "mujoco"
    assert engine_version("auto").startswith("mujoco ")
    require_engine("bullet")
    load_mujoco.cache_clear()
    monkeypatch.setitem(sys.modules, "mujoco", None)
    assert choose_engine() == "bullet"


def test_loading_pybullet_prints_nothing_and_keeps_what_others_say() -> None:
    require_engine("bullet")
    program = (
        "import os, sys; from sim.bullet import load_pybullet; load_pybullet();"
        "print('out'); print('err', file=sys.stderr)"
    )
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True, timeout=60
    )
    assert (done.stdout, done.stderr) == ("out\n", "err\n")


def test_a_motion_that_explodes_is_an_error_and_leaves_no_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    require_engine("mujoco")
    monkeypatch.chdir(tmp_path)
    world = MujocoWorld(SPEC)
    world.add_rotors(np.zeros(2))
    with pytest.raises(WorldError, match="unstable"):
        for _ in range(10):
            world.step_torques([1e30, -1e30])
    assert not list(tmp_path.iterdir())
    assert "unstable" in caplog.text


@dataclass(frozen=True)
class Driven:
    """What became of a drive."""

    poses: list[Pose2]
    by_odometry: Pose2
    steepest: float

    @property
    def slip(self) -> float:
        """How far the wheels rolled ahead of the robot [m]."""
        return self.by_odometry.x - self.poses[-1].x


def driven(
    engine: str, commands: list[Twist2], settings: PhysicsSettings = PhysicsSettings()
) -> Driven:
    """Drive commands, one a tick of 20 ms."""
    world = physics_world(engine, SPEC, Pose2(), settings)
    by_odometry, last, poses, steepest = Pose2(), world.positions, [], 0.0
    for twist in commands:
        world.step(DRIVE.wheels(twist), round(TICK / world.step_time))
        now = world.positions
        by_odometry, last = by_odometry @ DRIVE.moved(now - last), now
        poses.append(world.pose)
        steepest = max(steepest, world.tilt)
    world.close()
    return Driven(poses, by_odometry, steepest)


def both() -> tuple[str, str]:
    for engine in ENGINES:
        require_engine(engine)
    return ENGINES


EIGHT = [Twist2(0.15, 0.79 if tick * TICK % 15.9 < 7.95 else -0.79) for tick in range(1000)]
WAVES = [
    Twist2(0.1 + 0.05 * math.sin(tick / 50), 0.8 * math.sin(tick / 38)) for tick in range(1000)
]
STOP_AND_GO = [Twist2(0.35 if tick // 25 % 2 == 0 else 0, 0) for tick in range(500)]
HARD_TURNS = [Twist2(0, 2.5 if tick // 50 % 2 == 0 else -2.5) for tick in range(1000)]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("commands", "far", "turned"),
    [(EIGHT, 0.002, 0.004), (WAVES, 0.002, 0.002), (HARD_TURNS, 0.004, 0.005)],
    ids=["eight", "waves", "hard turns"],
)
def test_both_engines_drive_the_same_way_where_nothing_slips(
    commands: list[Twist2], far: float, turned: float
) -> None:
    bullet, mujoco = (driven(engine, commands) for engine in both())
    pairs = list(zip(bullet.poses, mujoco.poses, strict=True))
    assert max(one.distance_to(other) for one, other in pairs) < far
    assert max(abs(one.turn_to(other)) for one, other in pairs) < turned


def by_coulomb(mu: float, commands: list[Twist2], settings: PhysicsSettings) -> tuple[float, float]:
    """How far robot and wheels get along a line [m], by Coulomb's law of friction.

    The tyres carry what the caster does not, and whatever speeds the robot up loads the caster.
    """
    step, x, rolled, v, target = 1e-4, 0.0, 0.0, 0.0, 0.0
    share = 1 - math.exp(-step / settings.motor_lag)
    resting, by_push = GRAVITY * BEHIND / CASTER, HIGH / CASTER
    for twist in commands:
        for _ in range(round(TICK / step)):
            target += share * (twist.v - target)
            drag = settings.caster_friction if v > 1e-6 else 0.0
            grip, against = mu * (GRAVITY - resting), drag * resting
            most = (grip - against) / (1 + (mu + drag) * by_push)
            least = (-grip - against) / (1 - (mu - drag) * by_push)
            v += max(min(target - v, most * step), least * step)
            x += v * step
            rolled += target * step
    return x, rolled


@pytest.mark.slow
@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("mu", [0.5, 0.3, 0.1])
def test_tyres_that_spin_and_lock_slip_as_coulomb_s_law_says(engine: str, mu: float) -> None:
    """Ten starts and stops, half of the way at the lowest grip."""
    require_engine(engine)
    settings = PhysicsSettings(friction=mu)
    x, rolled = by_coulomb(mu, STOP_AND_GO, settings)
    # Where the tyres slip for moments only, those of MuJoCo grip 12 % too well.
    within = 0.15 if (engine, mu) == ("mujoco", 0.5) else 0.05
    assert driven(engine, STOP_AND_GO, settings).slip == pytest.approx(rolled - x, rel=within)


def shove(world: BulletWorld | MujocoWorld, force: float) -> None:
    """Push the body's centre of mass to the left in the next step [N]."""
    if isinstance(world, MujocoWorld):
        root = world._model.body(world._model.jnt_bodyid[0]).id
        world._data.xfrc_applied[root, 1] = force
        return
    centre, _ = world._bullet.getBasePositionAndOrientation(
        world._robot, physicsClientId=world._client
    )
    world._bullet.applyExternalForce(
        world._robot, -1, [0, force, 0], centre, world._bullet.WORLD_FRAME,
        physicsClientId=world._client,
    )  # fmt: skip


def pushed(engine: str, force: float, seconds: float) -> Pose2:
    """Where the robot is after somebody pushed it from its right, while its wheels stood."""
    world = physics_world(engine, SPEC, Pose2(), PhysicsSettings(friction=0.5))
    for _ in range(round(seconds / world.step_time)):
        shove(world, force)
        world.step(np.zeros(2))
    shove(world, 0.0)
    world.step(np.zeros(2), 500)
    assert abs(world.twist.v) < 1e-3
    pose = world.pose
    world.close()
    return pose


@pytest.mark.parametrize("force", [1.0, 4.0, 6.0])
def test_both_engines_let_it_be_pushed_as_far(force: float) -> None:
    """The tyres hold against a small push; at a larger one they slide, and the robot turns."""
    bullet, mujoco = (pushed(engine, force, 0.3) for engine in both())
    assert (bullet.y > 0.05) == (force > 2)
    assert bullet.y == pytest.approx(mujoco.y, rel=0.12, abs=0.001)
    assert abs(bullet.turn_to(mujoco)) < 0.5


@pytest.mark.parametrize("engine", ENGINES)
def test_the_same_seed_and_engine_make_the_same_run_bit_for_bit(engine: str) -> None:
    require_engine(engine)

    def run() -> list[tuple[object, ...]]:
        config = Config(robot="sim", map="square", seed=7, sim=SimSettings(engine=engine))
        program = build_program(config)
        shown = []
        for _ in range(150):
            program.engine.commands.put(FigureEightCommand(type="figure_eight"))
            tick = program.engine.step()
            shown.append((tick.truth, tick.odometry, tick.pose, tick.integrity.radius))
        assert program.robot.engine is not None
        assert program.robot.engine.startswith(engine)
        program.robot.close()
        return shown

    assert run() == run()


@pytest.mark.parametrize("engine", ENGINES)
def test_tyres_of_full_grip_hold_in_hard_starts_and_stops(engine: str) -> None:
    require_engine(engine)
    assert abs(driven(engine, STOP_AND_GO).slip) < 1e-4


@pytest.mark.parametrize("engine", ENGINES)
def test_it_topples_where_the_description_says(engine: str) -> None:
    """Braked harder than g d / h = 6.7 m/s^2, it lifts its caster; below, it stays level."""
    require_engine(engine)

    def steepest(effort: float) -> tuple[float, float]:
        strong = replace(
            SPEC, joints=tuple(replace(joint, max_effort=effort) for joint in SPEC.joints)
        )
        settings = PhysicsSettings(motor_lag=0, friction=1.5)
        world = physics_world(engine, strong, Pose2(), settings)
        world.step(np.full(2, 14.0), 500)
        before, most = world.twist.v, 0.0
        world.step(np.zeros(2), 10)
        braked = (before - world.twist.v) / (10 * world.step_time)
        for _ in range(60):
            world.step(np.zeros(2))
            most = max(most, world.tilt)
        world.close()
        return braked, most

    braked, tilt = steepest(0.06)
    assert 6.0 < braked < 6.7 and tilt < math.radians(0.1)
    braked, tilt = steepest(0.07)
    assert 6.7 < braked < 9.0 and math.radians(0.8) < tilt < math.radians(1.5)


def test_a_blocked_wheel_turns_the_robot_about_it_in_both() -> None:
    poses = []
    for engine in both():
        world = physics_world(engine, SPEC)
        wheels = PhysicsWheels(world, SPEC)
        wheels.plant(0).stalled = True  # type: ignore[attr-defined]
        wheels.plant(1).drive(0.5 * SPEC.joints[1].direction)
        for _ in range(1500):
            wheels.step(0.001)
        poses.append(world.pose)
        assert abs(world.positions[0]) < 1e-5
        world.close()
    assert poses[0].distance_to(poses[1]) < 0.002
    assert abs(poses[0].turn_to(poses[1])) < 0.03


@pytest.mark.slow
@pytest.mark.parametrize("engine", ENGINES)
def test_a_robot_that_stands_for_a_minute_stays_where_it_is(engine: str) -> None:
    require_engine(engine)
    world = physics_world(engine, SPEC, Pose2(0.3, -0.2, 2.5))
    world.step(np.zeros(2), 30_000)
    assert world.pose.distance_to(Pose2(0.3, -0.2, 2.5)) < 3e-5
    assert abs(world.pose.turn_to(Pose2(0.3, -0.2, 2.5))) < 3e-4
    world.close()
