"""Programs with models of a user's own, quickly made: robot and field are made only once."""

from dataclasses import replace

import engine_runs
import numpy as np

from app.engine.added_models import AddedModels, choice_of
from app.engine.commands import apply
from app.engine.controls import Controls
from app.engine.driving import Driving
from app.engine.engine import Engine
from app.engine.localization import Localization
from app.engine.program import Program
from app.engine.snapshot import Snapshot
from app.features.own_models.own_models import OwnModels
from robot.driving.differential_drive import DifferentialDrive
from robot.driving.drive_controller import DriveController
from robot.driving.odometry import Odometry
from robot.localization.parameters import FilterParameters, LocalizationParameters

ONE_CLOUD = LocalizationParameters(filter=FilterParameters(filter="particles"))
"""A filter that asks no other evidence than the model under test."""
FLAT = """
    import numpy as np

    class Flat:
        def log_likelihood(self, poses, scan):
            return np.zeros(len(poses))
"""
STILL = """
    class Still:
        def sample(self, poses, moved, rng):
            return poses
"""


def run(program: Program, seconds: float, *renewed) -> Snapshot:
    """What is shown at the end of a run."""
    return engine_runs.run(program, seconds, *renewed)[-1]


def undoubted(shown: Snapshot) -> list[str]:
    """What is told of a model, but that it finds no robot: most models here are not meant to."""
    return [words for words in shown.problems.present if "beside the true one" not in words]


def with_own(base: Program, path="", name="Flat", motion="", folder="") -> Program:
    """A new engine around the robot of another program, back at its start."""
    sensor = path and f"{path}:{name}"
    return with_added(base, OwnModels(base.field, sensor=sensor, motion=motion, folder=str(folder)))


def with_added(base: Program, *added: AddedModels) -> Program:
    """The same with any models that features may add."""
    kinematics = DifferentialDrive(base.robot.spec)
    base.robot.place(base.field.start)
    base.robot.write(np.zeros(2))
    scanner = base.engine.localization.scanner
    controls = Controls(
        base.robot,
        Odometry(kinematics, base.config.odometry),
        Localization(scanner, base.field, ONE_CLOUD, np.random.default_rng(0), added=added),
        Driving(DriveController(kinematics, base.config.drive), base.config.drive.cmd_vel_timeout),
        base.field.start,
    )
    engine = Engine(controls, apply)
    return replace(base, engine=engine, given=choice_of(added))
