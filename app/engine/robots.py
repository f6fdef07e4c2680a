"""Finds the robot that the configuration names, with what is known of it, and builds it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

from app.engine.plugging import plugged
from app.engine.robot_kind import Blueprint, RobotKind
from app.engine.simulated_robots import KINEMATIC, SIM
from app.languages.marking import phrase
from app.settings.config import AUTO, Config
from app.settings.profiles import NONE, own_profile
from robot.description.profile import load_profile
from robot.description.spec import RobotSpec
from robot.errors import PackageError
from robot.fields.field import Field
from robot.interface import Robot
from robot.settings import SettingError


def robot_kind(config: Config) -> RobotKind:
    """Return what kind of robot the configuration names.

    Raises:
        SettingError: there is no such robot; names those that there are.
    """
    robots = plugged().robots
    if config.robot == AUTO:
        return SIM
    if config.robot not in robots:
        valid = ", ".join((AUTO, *robots))
        words = phrase(f"robot is {config.robot!r}; valid are {valid}") + plugged().without
        raise SettingError(". ".join((words, *plugged().features.failures)))
    return robots[config.robot]


def robot_spec(config: Config) -> RobotSpec:
    """Return the robot's description, as its profile corrects it if it has one.

    Raises:
        SpecError: the profile cannot be read, or is of another robot.
    """
    spec, path = robot_kind(config).description(), profile_file(config)
    return spec if path is None else load_profile(path).applied_to(spec)


def profile_file(config: Config) -> Path | None:
    """Return the profile that holds; None if the robot is as described.

    Without a setting, that is a real robot's own one. Simulated robots have none of their own: each
    seed is another robot.
    """
    if config.profile:
        return None if config.profile == NONE else Path(config.profile)
    path = own_file(config)
    return path if path and path.exists() else None


def own_file(config: Config) -> Path | None:
    """Return the file of a real robot's own profile; None if the robot is simulated."""
    kind = robot_kind(config)
    return None if kind.is_simulated else own_profile(kind.description().name)


def build_robot(
    config: Config,
    spec: RobotSpec,
    field: Field,
    rng: np.random.Generator,
    wait: Callable[[float], None],
) -> Robot:
    """Build the robot that the configuration names."""
    return robot_kind(config).build(Blueprint(config, spec, field, rng, wait))


def resolve_robot(config: Config) -> tuple[Config, str | None]:
    """Replace the robot ``auto``, and the physics engine ``auto``, by what is available.

    Returns the configuration with both; and why the simulator with physics is not available, if
    the robot was to be chosen.

    Raises:
        PackageError: the robot, or an engine by name, was asked for and is not installed.
        SettingError: there is no such robot.
    """
    kind = robot_kind(config)
    try:
        return kind.resolve(replace(config, robot=kind.name)), None
    except PackageError as error:
        if config.robot != AUTO or config.sim.engine != AUTO:
            raise
        return replace(config, robot=KINEMATIC.name), str(error)
