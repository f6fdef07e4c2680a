"""What the page greys out has no effect: other values of it give the same run, bit for bit."""

from __future__ import annotations

import dataclasses
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from engine_runs import EIGHT, kinematic, run

from app.engine.commands import apply
from app.engine.controls import Controls
from app.engine.driving import Driving
from app.engine.engine import Engine
from app.engine.localization import Localization
from app.engine.parameter_changes import changed
from app.engine.program import Program
from app.engine.snapshot import Snapshot
from robot.description.spec import RobotSpec
from robot.driving.differential_drive import DifferentialDrive
from robot.driving.drive_controller import DriveController
from robot.driving.odometry import Odometry
from robot.geometry import Array
from robot.interface import Reading
from robot.localization.filter_kinds import FILTERS
from robot.localization.models.motion_models import MOTION_MODELS
from robot.localization.parameters import LocalizationParameters
from robot.localization.used_parameters import idle_parameters
from robot.settings import describe

pytestmark = pytest.mark.slow

CHOICES = [
    *({"filter": name} for name in FILTERS),
    {"filter": "particles", "laser_model_type": "beam"},
    {"filter": "particles", "laser_model_type": "likelihood_field_prob"},
    {"filter": "particles", "laser_model_type": "likelihood_field_prob", "do_beamskip": True},
    *({"filter": "particles", "robot_model_type": name} for name in MOTION_MODELS),
    {"filter": "hypotheses", "laser_model_type": "beam", "robot_model_type": "velocity"},
    {"filter": "grid", "robot_model_type": "velocity"},
    {"filter": "kalman", "robot_model_type": "omni"},
]  # fmt: skip
SMALL = {"max_particles": 300, "min_particles": 100}
SECONDS = 1.2


@dataclasses.dataclass
class Repeating:
    """A robot that answers as another one did: its noise is the same for all."""

    name: str
    spec: RobotSpec
    readings: list[Reading]

    def read(self) -> Reading:
        return self.readings.pop(0)

    def write(self, velocities: Array) -> Array:
        return velocities

    def close(self) -> None:
        """Nothing was opened."""


@dataclasses.dataclass(frozen=True)
class Base:
    """A program with a robot, and what its robot answered."""

    program: Program
    readings: list[Reading]


@pytest.fixture(scope="module")
def base() -> Base:
    program = kinematic(map="stub")
    return Base(program, [shown.reading for shown in run(program, SECONDS, EIGHT)])


def followed(base: Base, parameters: LocalizationParameters) -> list[Snapshot]:
    """The drive with these parameters, and the same chance."""
    program, first = base.program, base.program.engine.localization
    robot = Repeating("repeated", program.robot.spec, list(base.readings))
    kinematics = DifferentialDrive(robot.spec)
    chance = np.random.default_rng(5)
    controls = Controls(
        robot,
        Odometry(kinematics, program.config.odometry),
        Localization(
            first.scanner, program.field, parameters, chance, entries=first.models.entries
        ),
        Driving(DriveController(kinematics, program.config.drive), 0.3),
        program.field.start,
    )
    return run(replace(program, engine=Engine(controls, apply)), SECONDS, EIGHT)


def belief(shown: Snapshot) -> tuple[object, ...]:
    """All that is believed at a tick, and what is claimed of it, to the last bit."""
    estimate = shown.estimate
    places = [
        (each.weight, each.pose, each.covariance.tobytes())
        for each in (estimate.hypotheses if estimate else ())
    ]
    cloud = shown.filter.cloud.poses.tobytes(), shown.filter.cloud.weights.tobytes()
    return shown.pose, places, cloud, shown.integrity


def others(parameters: LocalizationParameters, names: frozenset[str]) -> dict[str, Any]:
    """Another valid value for each of these parameters."""
    values: dict[str, Any] = {}
    for group in dataclasses.fields(parameters):
        held = getattr(parameters, group.name)
        for name, known in describe(held).items():
            if name in names:
                values[name] = other(getattr(held, name), known)
    return values


def other(value: Any, known: Any) -> Any:
    if known.choices:
        return next(choice for choice in known.choices if choice != value)
    if isinstance(value, bool):
        return not value
    more = value * 1.25 if value else 0.5 * min(known.high, 1.0)
    result = more if more <= known.high else value * 0.75
    return max(value + 1, round(result)) if isinstance(value, int) else result


@pytest.mark.parametrize("choice", CHOICES, ids=lambda choice: " ".join(map(str, choice.values())))
def test_what_has_no_effect_has_none(base: Base, choice) -> None:
    parameters = changed(LocalizationParameters(), SMALL | choice)
    idle = idle_parameters(parameters)
    values = others(parameters, idle)
    assert values.keys() == idle and idle
    changed_run = followed(base, changed(parameters, values))
    for before, now in zip(followed(base, parameters), changed_run, strict=True):
        assert belief(before) == belief(now)


@pytest.mark.parametrize("name", MOTION_MODELS)
def test_each_motion_model_has_the_settings_that_it_uses(base: Base, name: str) -> None:
    """A setting that is not idle changes the run."""
    parameters = changed(
        LocalizationParameters(), SMALL | {"filter": "particles", "robot_model_type": name}
    )
    first = [belief(shown) for shown in followed(base, parameters)]
    used = set(describe(parameters.motion)) - {"robot_model_type"} - idle_parameters(parameters)
    assert used
    for setting in used:
        values = others(parameters, frozenset([setting]))
        assert first != [belief(shown) for shown in followed(base, changed(parameters, values))]


def test_what_has_an_effect_has_one(base: Base) -> None:
    parameters = changed(LocalizationParameters(), SMALL | {"filter": "particles"})
    first = [belief(shown) for shown in followed(base, parameters)]
    for name in ("sigma_hit", "alpha3", "z_rand", "max_particles"):
        values = others(parameters, frozenset([name]))
        assert first != [belief(shown) for shown in followed(base, changed(parameters, values))]
