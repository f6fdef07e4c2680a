"""A robot whose camera sees the board that a test shows it, with its pages."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace

import numpy as np
from apps import listening

from app.engine.build import build_program
from app.engine.engine_thread import EngineThread
from app.page.outlets import Outlets
from app.page.server import create_app
from app.page.tokens import Tokens
from app.settings.config import Config
from robot.calibration.lens.sighting import Grey
from robot.geometry import Array
from robot.interface import Frame, Reading, Robot
from sim.real_time import RealTime


class BoardRobot:
    """Another robot, with other pictures."""

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self.name, self.spec = robot.name, robot.spec
        self.shown: Grey = np.full((robot.spec.lens.height, robot.spec.lens.width), 90, np.uint8)
        """What its camera sees."""

    def read(self) -> Reading:
        reading = self._robot.read()
        if reading.frame is None:
            return reading
        return replace(reading, frame=Frame(reading.frame.stamp, self.shown.copy()))

    def write(self, velocities: Array) -> Array:
        return self._robot.write(velocities)

    def close(self) -> None:
        self._robot.close()


@contextmanager
def board_robot(
    tokens: Tokens | None = None, *, real: bool = False
) -> Iterator[tuple[BoardRobot, str]]:
    """Yield such a robot, and the address of its pages; if it is real, it has its own profile."""
    config = Config(robot="kinematic", map="stub")
    robot = BoardRobot(build_program(config, RealTime()).robot)
    program = build_program(config, robot=robot)
    if real:
        program = replace(program, config=replace(config, robot="buildhat"))
    app = create_app(program, EngineThread(program.engine), Outlets(program), tokens)
    with listening(app) as address:
        yield robot, address
