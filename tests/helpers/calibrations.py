"""Drives of simulated robots that calibrate themselves."""

from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np

from app.engine.build import Streams, load_field
from app.engine.robots import build_robot
from app.settings.conditions import apply_condition
from app.settings.config import MAPS, Config
from robot.calibration.drive_log import DriveLog, DriveRecorder
from robot.calibration.programme import velocity
from robot.description.spec import RobotSpec
from robot.description.unknowns import COUNT, Differences
from robot.driving.differential_drive import DifferentialDrive
from robot.fields.field import Field
from robot.geometry import Array, Pose2, Twist2
from sim.imperfections import draw
from sim.simulated import no_wait

HAND_BUILT, SEED = "hand-built", 530
"""A robot that most tests calibrate."""

SPEC = RobotSpec.load()
SQUARE = load_field("square", MAPS)
START_COVARIANCE = np.diag(np.square([0.05, 0.05, 0.17]))


@cache
def driven(
    world: str,
    seed: int,
    seconds: float,
    motion: Callable[[float], Twist2] = velocity,
    map_name: str = "square",
    *,
    calibrated: bool = False,
    steer: Callable[[Pose2], Twist2 | None] | None = None,
) -> tuple[DriveLog, Array, Array]:
    """A drive, the true unknowns (15,), and the true poses (k, 3) at the pictures.

    ``steer`` drives by where the robot truly is, instead of by the time, and ends with None.
    """
    taped = load_field(map_name, MAPS)
    config = apply_condition(Config(robot="sim"), world)
    # More pictures than the recorder takes would only be rendered.
    camera = replace(config.sim.camera, frame_rate=10.0)
    config = replace(config, sim=replace(config.sim, camera=camera))
    true = draw(SPEC, config.sim.imperfections, Streams.of(seed).robot)
    robot = build_robot(config, SPEC, taped, Streams.of(seed).robot, no_wait)
    recorder = DriveRecorder(SPEC, config.scanner, taped.tape, calibrated=calibrated)
    drive = DifferentialDrive(SPEC)
    truths = []
    try:
        while not truths or truths[-1][0] < seconds:
            reading = robot.read()
            recorder.add(reading)
            assert reading.truth is not None
            truths.append((reading.stamp, *reading.truth.to_array()))
            wanted = motion(reading.stamp) if steer is None else steer(reading.truth)
            if wanted is None:
                break
            robot.write(drive.wheels(wanted))
    finally:
        robot.close()
    values = np.zeros(COUNT)
    delay = config.sim.camera.stamp_error
    differences = Differences.between(SPEC, true, delay).values
    values[: len(differences)] = differences
    log, path = recorder.log, np.array(truths)
    path[:, 3] = np.unwrap(path[:, 3])
    exposed = log.stamps - delay
    poses = [np.interp(exposed, path[:, 0], column) for column in path.T[1:]]
    return log, values, np.column_stack(poses)


def placed(seed: int, taped: Field = SQUARE) -> Pose2:
    """Where somebody says that the robot is: off by some centimetres and degrees."""
    error = np.random.default_rng(seed).normal(0.0, (0.03, 0.03, 0.1))
    return Pose2(*(taped.start.to_array() + error).tolist())
