"""The simulated robot without forces: it errs as the one with forces, but for what needs them."""

from __future__ import annotations

import sys

import numpy as np
import pytest
from engine_runs import EIGHT, PERFECT, kinematic, run
from simulators import require_engine

from app.engine.build import build_program
from app.engine.commands import check
from app.engine.robots import build_robot
from app.features.faults.commands import with_faults
from app.features.faults.messages import SetFaultsCommand
from app.page.telemetry import field_message
from app.settings.conditions import CONDITIONS, apply_condition
from app.settings.config import MAPS, Config, with_settings
from app.settings.faults import CAMERA, ROBOT, TABLES, fault_values
from robot.description.spec import RobotSpec
from robot.driving.differential_drive import DifferentialDrive
from robot.fields.field_loading import load_field
from robot.geometry import Twist2
from robot.interface import Reading
from sim.engines import ENGINES, engine_is_here
from sim.floor_camera import CameraSettings
from sim.simulated import SimSettings, SimulatedRobot, no_wait

pytestmark = pytest.mark.slow

SPEC, FIELD = RobotSpec.load(), load_field("square", MAPS)
DRIVE = DifferentialDrive(SPEC)
FORWARD = Twist2(0.15, 0.4)
LAP = 15.9
"""Time of one lap of ``odometry_errors`` [s]."""
WORSE: dict[str, float | str] = {
    "slip_sd": 0.2, "wheel_radius_sd": 0.05, "track_sd": 0.05, "camera_angle_sd": 0.5,
    "camera_position_sd": 0.005, "focal_length_sd": 0.02, "noise": 20.0, "light": 0.5,
    "uneven_light": 0.5, "glare": 150.0, "clutter": "all", "floor_scale": 1.02, "exposure": 0.03,
    "blur": 3.0, "stamp_error": 0.03, "frame_rate": 7.0, "lost_share": 0.5, "lost_burst": 0.5,
    "gap": 14.0,
}  # fmt: skip
"""Each fault with a value that is worse than the usual one."""


def robot_of(config: Config) -> SimulatedRobot:
    return build_robot(config, SPEC, FIELD, np.random.default_rng(config.seed), no_wait)


def driven(robot: SimulatedRobot, seconds: float = 1.0) -> list[Reading]:
    robot.write(DRIVE.wheels(FORWARD))
    readings = [robot.read() for _ in range(round(seconds / 0.02))]
    robot.close()
    return readings


def wheels(readings: list[Reading]) -> list[tuple[object, ...]]:
    """What encoders say and where the robot truly is."""
    return [(*one.positions, *one.velocities, one.truth) for one in readings]


def pictures(readings: list[Reading]) -> list[tuple[float, bytes]]:
    return [(one.frame.stamp, one.frame.image.tobytes()) for one in readings if one.frame]


def odometry_errors(robot: SimulatedRobot, laps: float = 2.0) -> list[float]:
    """Distance of odometry from the truth over laps of a figure-eight, at each reading [m]."""
    first = robot.read()
    odometry, last, errors = first.truth, first.positions, []
    for tick in range(round(laps * LAP / 0.02)):
        turning = 0.79 if tick * 0.02 % LAP < LAP / 2 else -0.79
        robot.write(DRIVE.wheels(Twist2(0.15, turning)))
        reading = robot.read()
        odometry, last = odometry @ DRIVE.moved(reading.positions - last), reading.positions
        errors.append(odometry.distance_to(reading.truth))
    robot.close()
    return errors


def root_mean_square(kind: str, seed: int) -> float:
    rare = SimSettings(camera=CameraSettings(frame_rate=1))
    errors = odometry_errors(robot_of(Config(robot=kind, seed=seed, sim=rare)))
    return float(np.sqrt(np.mean(np.square(errors))))


def test_odometry_drifts_as_it_does_with_forces() -> None:
    require_engine()
    with_forces, without = (
        np.mean([root_mean_square(kind, seed) for seed in range(6)])
        for kind in ("sim", "kinematic")
    )
    assert without > 0.05
    assert without == pytest.approx(with_forces, rel=0.1)


def test_odometry_of_a_perfect_robot_is_the_truth() -> None:
    assert max(odometry_errors(robot_of(Config(robot="kinematic", sim=PERFECT)))) < 1e-9


def test_the_same_seed_repeats_bit_for_bit() -> None:
    one, same, other = (driven(robot_of(Config(robot="kinematic", seed=at))) for at in (4, 4, 5))
    assert wheels(one) == wheels(same) and pictures(one) == pictures(same)
    assert wheels(one) != wheels(other) and pictures(one) != pictures(other)


def changed(fault: str) -> tuple[list[Reading], list[Reading]]:
    """Readings with a fault, and of the same robot without it."""
    both = []
    # Pictures that are lost come in bursts only where some are lost.
    config = with_settings(
        Config(robot="kinematic", seed=2),
        {"sim.camera.lost_share": 0.4 if fault == "lost_burst" else 0.0},
    )
    for values in ({fault: WORSE[fault]}, {}):
        robot = robot_of(config)
        robot.change(with_faults(robot.settings, values))
        both.append(driven(robot))
    return both[0], both[1]


def test_each_fault_is_tried_below() -> None:
    assert set(WORSE) == set(TABLES)


@pytest.mark.parametrize("fault", ROBOT)
def test_each_slider_of_the_robot_changes_what_it_names(fault: str) -> None:
    worse, usual = changed(fault)
    counted = [one.positions.tolist() for one in worse] != [one.positions.tolist() for one in usual]
    rolled = [one.truth for one in worse] != [one.truth for one in usual]
    assert counted == (fault == "slip_sd"), "only slip turns wheels that do not roll"
    assert rolled == (fault in ("wheel_radius_sd", "track_sd"))
    assert (pictures(worse) != pictures(usual)) == (fault != "slip_sd")


@pytest.mark.parametrize("fault", CAMERA)
def test_each_slider_of_the_camera_changes_pictures_alone(fault: str) -> None:
    worse, usual = changed(fault)
    assert pictures(worse) != pictures(usual)
    assert wheels(worse) == wheels(usual)


def test_the_program_takes_each_fault_from_the_page() -> None:
    program = kinematic(map="stub")
    run(program, 0.1)
    for name, value in WORSE.items():
        command = SetFaultsCommand(type="set_faults", values={name: value})
        check(command, program)
        program.engine.commands.put(command)
    run(program, 0.1)
    assert fault_values(program.robot.settings) == WORSE


@pytest.mark.parametrize("name", [name for name in CONDITIONS if name not in ("default", "fast")])
def test_each_condition_makes_it_worse(name: str) -> None:
    # So that a bump, and a camera's pause in each 15 s, fall into the second that is driven.
    config = with_settings(
        Config(robot="kinematic", seed=2),
        {"sim.imperfections.bump_time": 0.3, "sim.camera.lost_burst": 0.1},
    )
    worse = apply_condition(config, name)
    assert worse != config
    usual, other = driven(robot_of(config)), driven(robot_of(worse))
    assert (wheels(usual), pictures(usual)) != (wheels(other), pictures(other))


def test_the_fast_condition_is_driven_fast() -> None:
    config = apply_condition(Config(robot="kinematic", map="stub", sim=PERFECT), "fast")
    slow, fast = (
        max(shown.twist.v for shown in run(build_program(one), 1.0, EIGHT))
        for one in (Config(robot="kinematic", map="stub"), config)
    )
    assert fast > 1.5 * slow


def test_only_where_no_engine_is_installed_the_page_offers_one(monkeypatch) -> None:
    program = kinematic(map="stub")
    if engine_is_here():
        assert not field_message(program).engine_missing
    for module in (engine.module for engine in ENGINES.values()):
        monkeypatch.setitem(sys.modules, module, None)
    assert field_message(program).engine_missing
