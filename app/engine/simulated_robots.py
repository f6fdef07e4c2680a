"""The simulated robots: one that forces move, and one whose wheels roll as if on rails."""

from __future__ import annotations

import copy
from collections.abc import Callable
from dataclasses import replace

from app.engine.robot_kind import Blueprint, RobotKind
from app.languages.marking import phrase
from app.settings.config import Config
from robot.description.spec import RobotSpec
from robot.geometry import Pose2
from sim.encoders import Encoders
from sim.engines import choose_engine, engine_version, physics_world
from sim.imperfections import bumped, draw
from sim.simulated import RobotFactory, SimulatedRobot
from sim.world import KinematicWorld, World

NewWorld = Callable[[RobotSpec, Pose2], World]
"""Makes the world that moves a robot, as it truly is, from a start."""


def build_physical(blueprint: Blueprint) -> SimulatedRobot:
    """Build the robot that forces move."""
    settings = blueprint.config.sim

    def world(true: RobotSpec, start: Pose2) -> World:
        return physics_world(settings.engine, true, start, settings.physics)

    return _built(blueprint, phrase("Simulated robot"), world, engine_version(settings.engine))


def build_kinematic(blueprint: Blueprint) -> SimulatedRobot:
    """Build the robot that has no forces."""
    return _built(blueprint, phrase("Kinematic robot"), KinematicWorld, None)


def _built(
    blueprint: Blueprint, name: str, new_world: NewWorld, engine: str | None
) -> SimulatedRobot:
    spec, rng, settings = blueprint.spec, blueprint.rng, blueprint.config.sim
    factory = RobotFactory(settings.imperfections, copy.deepcopy(rng), new_world, engine)
    true = draw(spec.as_drawn, settings.imperfections, rng)
    world = new_world(true, blueprint.field.start)
    encoders = Encoders(spec, settings.imperfections, rng)
    bump = settings.imperfections.bump_time, bumped(true, settings.imperfections).floor_view
    return SimulatedRobot(
        name,
        spec,
        blueprint.field,
        world=world,
        encoders=encoders,
        camera=settings.camera,
        rng=rng,
        factory=factory,
        view=true.floor_view,
        bump=None if settings.imperfections.bump == "none" else bump,
        wait=blueprint.wait,
    )


def _with_engine(config: Config) -> Config:
    return replace(config, sim=replace(config.sim, engine=choose_engine(config.sim.engine)))


SIM = RobotKind(
    name="sim",
    about="with physics",
    build=build_physical,
    is_simulated=True,
    has_forces=True,
    resolve=_with_engine,
)
KINEMATIC = RobotKind(
    name="kinematic",
    about="without, its wheels roll as if on rails",
    build=build_kinematic,
    is_simulated=True,
)
ROBOTS = (SIM, KINEMATIC)
