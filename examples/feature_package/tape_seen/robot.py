"""The robot ``ideal``: without forces, and all of it is exactly as it is described."""

from dataclasses import replace

from app.engine.robot_kind import Blueprint, RobotKind
from app.engine.simulated_robots import build_kinematic
from robot.interface import Robot
from sim.imperfections import Imperfections


def robots() -> tuple[RobotKind, ...]:
    """Return what ``--robot`` can choose besides."""
    about = "rolls exactly as it is told"
    return (RobotKind(name="ideal", about=about, build=_build, is_simulated=True),)


def _build(blueprint: Blueprint) -> Robot:
    sim = replace(blueprint.config.sim, imperfections=Imperfections.none())
    return build_kinematic(replace(blueprint, config=replace(blueprint.config, sim=sim)))
