"""Makes the robot that the configuration names: a simulated one, or the Build HAT."""

from __future__ import annotations

import copy
from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np

from app.languages.marking import phrase
from app.settings.config import Config
from app.settings.profiles import profile_file
from robot.calibration.profile import load_profile
from robot.description.spec import RobotSpec
from robot.errors import PackageError
from robot.fields.field import Field
from robot.hat.build_hat import BuildHat
from robot.interface import Robot
from sim.bullet import BulletWorld, load_pybullet
from sim.encoders import Encoders
from sim.imperfections import Imperfections, bumped, draw
from sim.simulated import Making, SimulatedRobot
from sim.world import KinematicWorld


def robot_spec(config: Config) -> RobotSpec:
    """Return the robot's description, as its profile corrects it if it has one.

    Raises:
        SpecError: the profile cannot be read, or is of another robot.
    """
    spec, path = RobotSpec.load(), profile_file(config)
    return spec if path is None else load_profile(path).applied_to(spec)


def build_robot(
    config: Config,
    spec: RobotSpec,
    field: Field,
    rng: np.random.Generator,
    wait: Callable[[float], None],
) -> Robot:
    """Build the robot that the configuration names."""
    if config.robot == "buildhat":
        return BuildHat.open(spec, config.build_hat, config.camera)
    return build_simulated(config, spec, field, rng, wait)


def build_simulated(
    config: Config,
    spec: RobotSpec,
    field: Field,
    rng: np.random.Generator,
    wait: Callable[[float], None],
) -> SimulatedRobot:
    """Build the simulated robot that the configuration names."""
    if config.robot == "sim":
        drawing = copy.deepcopy(rng)
        true = draw(spec.as_drawn, config.sim.imperfections, rng)
        world = BulletWorld(true, field.start, settings=config.sim.physics)
        encoders = Encoders(spec, config.sim.imperfections, rng)
        seen, imperfections = true.floor_view, config.sim.imperfections
        bump = imperfections.bump_time, bumped(true, imperfections).floor_view
        return SimulatedRobot(
            phrase("Simulated robot"),
            spec,
            field,
            world,
            encoders,
            config.sim.camera,
            rng,
            wait,
            seen,
            None if imperfections.bump == "none" else bump,
            Making(imperfections, drawing, partial(BulletWorld, settings=config.sim.physics)),
        )
    perfect = Encoders(spec, Imperfections.none(), rng)
    return SimulatedRobot(
        phrase("Kinematic robot"),
        spec,
        field,
        KinematicWorld(spec, field.start),
        perfect,
        config.sim.camera,
        rng,
        wait,
    )


def resolve_robot(config: Config) -> tuple[Config, str | None]:
    """Replace the robot ``auto`` by an available one.

    Returns the configuration with that robot; and why the simulator with physics is not available,
    or None.
    """
    if config.robot != "auto":
        return config, None
    try:
        load_pybullet()
    except PackageError as error:
        return replace(config, robot="kinematic"), str(error)
    return replace(config, robot="sim"), None
