"""A kind of robot that the program can have, and what it says of itself."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from app.settings.config import Config
from robot.description.spec import RobotSpec
from robot.fields.field import Field
from robot.interface import Robot


@dataclass(frozen=True, eq=False)
class Blueprint:
    """What a robot is built from."""

    config: Config
    spec: RobotSpec
    """The robot as it is known."""
    field: Field
    """The floor on which it stands."""
    rng: np.random.Generator
    """What a simulated robot draws comes from it."""
    wait: Callable[[float], None]
    """Called with each stamp of a simulated robot."""


def as_it_is(config: Config) -> Config:
    """Leave a configuration as it is."""
    return config


def require_robot(robot: Robot) -> Robot:
    """Return a robot as the program needs it.

    Raises:
        TypeError: it is none, or has no name or description; names what is valid.
    """
    for name, kind in (("name", str), ("spec", RobotSpec)):
        if not isinstance(value := getattr(robot, name, None), kind):
            raise TypeError(f"the robot's {name} is {value!r}; valid is a {kind.__name__}")
    for name in ("read", "write", "close"):
        if not callable(getattr(robot, name, None)):
            raise TypeError(f"the robot has no {name}; robot/interface.py says what it does")
    return robot


@dataclass(frozen=True, kw_only=True)
class RobotKind:
    """One choice of ``--robot``."""

    name: str
    """What ``--robot`` calls it."""
    about: str
    """What it is, in a few words, for ``brickpose doctor``."""
    build: Callable[[Blueprint], Robot]
    """Builds one, which is active from then on."""
    description: Callable[[], RobotSpec] = RobotSpec.load
    """Returns it as it is drawn, without a profile; by default that is the program's own robot."""
    is_simulated: bool = False
    """Whether a seed draws it: conditions and faults have an effect. A real robot keeps a profile
    of its own, which its calibrations write."""
    has_forces: bool = False
    """Whether an engine of physics moves it."""
    options: tuple[str, ...] = ()
    """Options of the command line that have an effect with this one alone, as ``serial_port``."""
    resolve: Callable[[Config], Config] = as_it_is
    """Fills in what a configuration leaves open; raises a PackageError if the robot cannot be had
    here."""
