"""Benchmark of the engine's steps with all routes or none: DDS, rosbridge, Foxglove, recording."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import threading
import time
from collections import deque
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from app.engine.build import build_program
from app.engine.program import Program
from app.engine.robots import build_robot
from app.messages.driving_commands import FigureEightCommand
from app.page.listening import listen
from app.page.serving import Server
from app.settings.config import MAPS, ROOT, Config
from app.settings.groups import RecordingSettings, Ros2Settings
from benchmarks.result import Result
from benchmarks.topics.fastdds import Peer, missing
from robot.description.spec import RobotSpec
from robot.fields.field_loading import load_field
from robot.geometry import Array
from robot.interface import Reading, Robot
from sim.real_time import RealTime

TURNS = 3
SECONDS = 10.0
SETTLE_S = 5.0
"""Time after a start: compiled code is loaded, first clouds are large, readers find each other."""

READERS = 3
RENEW_S = 0.2


def measure() -> Result:
    """Measure the 99th percentile of step times, with all routes and with none in turns.

    Raises:
        RuntimeError: Fast DDS is not installed.
    """
    reason = missing()
    if reason is not None:
        raise RuntimeError(f"readers of another vendor's are missing: {reason}")
    every, none = Times(), Times()
    for _ in range(TURNS):
        none.add(_times(Config(robot="sim"), watched=False))
        with tempfile.TemporaryDirectory() as folder:
            every.add(_times(_all_on(Path(folder)), watched=True))
    return Result(
        unit="ms p99 of the engine's step with all routes on",
        brickpose=_ms(every.steps, 99),
        peer={"without": _ms(none.steps, 99)},
        more={
            "median with [ms]": _ms(every.steps, 50),
            "median without [ms]": _ms(none.steps, 50),
            "p99 with the simulation, with [ms]": _ms(every.ticks, 99),
            "p99 with the simulation, without [ms]": _ms(none.ticks, 99),
        },
    )


@dataclass
class Times:
    """Times of ticks [s]."""

    steps: list[float] = field(default_factory=list)
    """From the robot's reading until the next request: the engine's own work."""
    ticks: list[float] = field(default_factory=list)
    """With the simulation, which is the robot here."""

    def add(self, more: Times) -> None:
        """Add the times of another turn."""
        self.steps += more.steps
        self.ticks += more.ticks


class TimedRobot:
    """A robot that records the times between a reading and the next request."""

    def __init__(self, robot: Robot) -> None:
        self.name, self.spec = robot.name, robot.spec
        self.between: deque[float] = deque(maxlen=5000)
        self._robot = robot
        self._answered = time.monotonic()

    def read(self) -> Reading:
        """Return the robot's reading, and record the time since the last one."""
        self.between.append(time.monotonic() - self._answered)
        reading = self._robot.read()
        self._answered = time.monotonic()
        return reading

    def write(self, velocities: Array) -> Array:
        """Pass the velocities on to the robot."""
        return self._robot.write(velocities)

    def close(self) -> None:
        """Close the robot."""
        self._robot.close()


def _ms(times: list[float], percent: float) -> float:
    return 1e3 * float(np.percentile(times, percent))


def _all_on(folder: Path) -> Config:
    ros2 = Ros2Settings(dds=True, domain_id=1 + os.getpid() % 200, foxglove=True)
    recording = RecordingSettings(record=True, folder=str(folder))
    return replace(Config(robot="sim"), ros2=ros2, recording=recording)


def _times(config: Config, watched: bool) -> Times:
    """Measure the times of a program on the figure-eight."""
    pace = RealTime()
    rng = np.random.default_rng(0)
    spec, tape_field = RobotSpec.load(), load_field(config.map, MAPS)
    robot = TimedRobot(build_robot(config, spec, tape_field, rng, pace))
    program = build_program(config, robot=robot)
    listening = listen("127.0.0.1", 0)
    server = Server(program)
    thread = threading.Thread(target=server.run, args=(listening,), name="server")
    thread.start()
    try:
        with ExitStack() as clients:
            if watched:
                address = f"127.0.0.1:{listening.getsockname()[1]}"
                clients.enter_context(_readers(config.ros2, address))
            _drive(program, SETTLE_S)
            pace.busy.clear()
            robot.between.clear()
            _drive(program, SECONDS)
            return Times(list(robot.between), list(pace.busy))
    finally:
        server.stop()
        thread.join(20)


@contextmanager
def _readers(settings: Ros2Settings, address: str) -> Iterator[None]:
    command = [sys.executable, "-m", "benchmarks.topics.clients", address]
    time.sleep(SETTLE_S)
    with ExitStack() as stack:
        for _ in range(READERS):
            stack.enter_context(Peer(settings.domain_id)).read_live_topics()
        clients = subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, text=True)
        try:
            assert clients.stdout is not None
            for _ in range(2):
                if not clients.stdout.readline():
                    raise RuntimeError("a client of rosbridge or Foxglove has ended")
            yield
        finally:
            clients.kill()
            clients.wait()


def _drive(program: Program, seconds: float) -> None:
    until = time.monotonic() + seconds
    while time.monotonic() < until:
        program.engine.commands.put(FigureEightCommand(type="figure_eight"))
        time.sleep(RENEW_S)
