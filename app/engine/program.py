"""The running program: a robot with its engine, as page, ROS 2 and recordings see it."""

from __future__ import annotations

import dataclasses
import threading
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from app.engine.added_models import ModelChoice
from app.engine.control import ControlLoop
from app.engine.engine import Engine
from app.engine.robot_facts import RobotFacts
from app.settings.config import Config
from robot.fields.field import Field
from robot.interface import Robot
from robot.localization.estimate import Hypothesis
from sim.simulated import SimSettings


@dataclass(frozen=True)
class Program:
    """The parts of a program that other modules use."""

    engine: ControlLoop
    robot: Robot
    field: Field
    config: Config
    given: ModelChoice
    """Models of features at the start."""
    loop: Callable[[threading.Event], None] | None = None
    """The loop of a replay, which runs until the event is set; None uses the engine's own loop. A
    replay cannot be driven."""
    complaints: tuple[str, ...] = ()
    """What is amiss though the robot drives, as a feature that cannot be loaded; for people."""
    stopped: bool = False
    """Whether a stop holds that was given to the program before this one."""
    handed_on: Mapping[str, object] = dataclasses.field(default_factory=dict)
    """What features have to know of the program before this one, by their names."""

    @property
    def facts(self) -> RobotFacts:
        """What is known of the robot."""
        return RobotFacts.of(self.robot)

    def on_field(self, name: str, field: Field, place: Hypothesis | None) -> Program:
        """Return the next program, on another field, after this one has handed its robot over.

        Only one whose engine is elsewhere builds its own successor: ``app.engine.build`` has the
        others.

        Args:
            name: of the field, as ``Config.map``.
            field: the field.
            place: where the robot is in it; None: at its start.
        """
        raise NotImplementedError

    @property
    def faults(self) -> SimSettings:
        """The faults of a simulated robot now."""
        latest = self.engine.latest.get()
        return self.config.sim if latest is None or latest.faults is None else latest.faults


@dataclass(frozen=True)
class LocalProgram(Program):
    """A program whose engine is in this process: whoever has it may step it."""

    engine: Engine
