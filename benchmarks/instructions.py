"""Benchmark that counts instructions: what a second of a robot in bricks asks of its computer.

Instructions do not depend on what else a machine does, and tell roughly what another one needs. A
second has 50 ticks, 15 pictures and one page, which gets 30 ticks. Each part works on what was
recorded of such seconds, once for a time and once for twice that time: the difference is the part's
own. Valgrind counts.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np

from app.engine.build import build_program
from app.engine.mailboxes.rhythm import Rhythm
from app.engine.plugging import plug_in
from app.engine.program import LocalProgram
from app.engine.rest import PAGE_HZ
from app.engine.snapshot import Snapshot
from app.feature_search import find_features
from app.features.control.messages import SentTick
from app.features.control.parts import PartsReader, PartsWriter
from app.features.control.process import PARTS
from app.features.control.shared_ring import SharedRing
from app.messages.driving_commands import FigureEightCommand
from app.page.camera_stream import encoded
from app.page.outlets import Outlets
from app.page.telemetry import TelemetryWriter
from app.settings.config import ROOT, Config
from benchmarks.hat.bricks import Bricks
from benchmarks.result import Result
from robot.errors import PackageError
from robot.geometry import Array
from robot.hat.board import BoardDriver
from robot.hat.settings import BuildHatSettings
from robot.hat.start.bring_up import BringUp
from robot.interface import Reading, Robot
from sim.floor_camera import CameraSettings
from sim.simulated import PERIOD, SimSettings

SECONDS = 4
"""Each part is counted over this time and over twice that time [s]."""
BEFORE_S = 2
"""The filter has converged, and all is loaded, after this time [s]."""
FRAME_RATE = 15.0
COUNTED = re.compile(r"I\s+refs:\s+([\d,]+)")
NO_FILE = "/dev/null"
PROCESSOR = {"NUMBA_CPU_NAME": "x86-64-v3", "NUMBA_CPU_FEATURES": ""}
"""Valgrind knows no later instructions."""

Part = Callable[[int], None]
"""Does the work of so many seconds."""


def measure() -> Result:
    """Count each part's instructions for a second of driving.

    Raises:
        PackageError: valgrind is not installed.
    """
    ticks, pictures = _counted("ticks"), _counted("pictures")
    parts = {
        "control: 50 ticks without pictures": ticks,
        "control: scan and filter, 15 pictures": pictures - ticks,
        "control: board's line and speed loop": _counted("board"),
        "both: ticks to the server": _counted("sending"),
        "server: telemetry to one page": _counted("telemetry"),
        "server: camera's stream": _counted("camera"),
    }
    return Result(
        unit="million instructions a second",
        brickpose=sum(parts.values()),
        more={f"{name} [million]": count for name, count in parts.items()},
    )


def _counted(part: str) -> float:
    """Return how many instructions a part takes for a second [million]."""
    short, long = (_run(part, count * SECONDS) for count in (1, 2))
    return (long - short) / SECONDS / 1e6


def _run(part: str, seconds: int) -> int:
    command = [sys.executable, "-m", "benchmarks.instructions", part, str(seconds)]
    environment = {**os.environ, **PROCESSOR}
    subprocess.run(command, cwd=ROOT, env=environment, check=True)  # compile it
    valgrind = [
        "valgrind",
        "--tool=cachegrind",
        "--cache-sim=no",
        "--cachegrind-out-file=/dev/null",
    ]
    try:
        done = subprocess.run(
            [*valgrind, *command],
            cwd=ROOT,
            env=environment,
            check=True,
            stderr=subprocess.PIPE,
            text=True,
        )
    except FileNotFoundError as error:
        raise PackageError("valgrind is not installed: sudo apt install valgrind") from error
    counted = COUNTED.search(done.stderr)
    assert counted is not None, done.stderr
    return int(counted[1].replace(",", ""))


class Recorded:
    """A robot that gives the readings that another one gave."""

    def __init__(self, robot: Robot, readings: list[Reading]) -> None:
        self.name, self.spec = "recorded", robot.spec
        self._readings = iter(readings)

    def read(self) -> Reading:
        """Return the next reading."""
        return next(self._readings)

    def write(self, velocities: Array) -> Array:
        """Take the velocities as they are."""
        return velocities

    def close(self) -> None:
        """Do nothing."""


def build() -> LocalProgram:
    """Build the robot that is recorded: without forces, which no real robot computes."""
    sim = SimSettings(camera=CameraSettings(frame_rate=FRAME_RATE))
    return build_program(Config(robot="kinematic", sim=sim))


def driven(program: LocalProgram, seconds: float) -> Iterator[Snapshot]:
    """Drive the figure-eight."""
    for _ in range(round(seconds / PERIOD)):
        program.engine.commands.put(FigureEightCommand(type="figure_eight"))
        yield program.engine.step()


def engine_part(*, pictures: bool) -> Part:
    """Return the control loop on recorded readings, with their pictures or without."""

    def work(seconds: int) -> None:
        source = build()
        readings = [tick.reading for tick in driven(source, BEFORE_S + 2 * SECONDS)]
        source.robot.close()
        begun = round(BEFORE_S / PERIOD)
        if not pictures:
            bare = [replace(reading, frame=None) for reading in readings[begun:]]
            readings = readings[:begun] + bare
        program = build_program(source.config, robot=Recorded(source.robot, readings))
        for _ in driven(program, BEFORE_S + seconds):
            pass

    return work


def snapshots(seconds: int) -> tuple[LocalProgram, list[Snapshot]]:
    """Return a program, and the ticks of some seconds of the same drive."""
    program = build()
    ticks = list(driven(program, BEFORE_S + 2 * SECONDS))[round(BEFORE_S / PERIOD) :]
    return program, ticks[: round(seconds / PERIOD)]


def sent(ticks: list[Snapshot]) -> Iterator[Snapshot]:
    """Yield those of the ticks that a page gets."""
    rhythm = Rhythm()
    for tick in ticks:
        if tick.reading.frame is not None or rhythm.wait(tick.stamp) <= 0:
            rhythm.choose(tick.stamp, PAGE_HZ)
            yield tick


def telemetry(seconds: int) -> None:
    """Write the messages of the ticks for a page."""
    program, ticks = snapshots(seconds)
    writer = TelemetryWriter(program, Outlets(program, None, lambda following: None))
    for tick in sent(ticks):
        writer.message(tick).model_dump_json()


def camera(seconds: int) -> None:
    """Compress each picture."""
    _, ticks = snapshots(seconds)
    for tick in ticks:
        if tick.reading.frame is not None:
            encoded(tick, tick.reading.frame)


def sending(seconds: int) -> None:
    """Turn the ticks for a page into bytes, and back."""
    _, ticks = snapshots(seconds)
    ring = SharedRing()
    writer, reader = PartsWriter(PARTS, ring), PartsReader(ring)
    for tick in sent(ticks):
        reader.read(writer.write(SentTick(tick, unbroken=False)))


class HeardBricks(Bricks):
    """Two motors, and all that their driver was told."""

    def __post_init__(self) -> None:
        self.heard: list[tuple[float, bytes]] = []
        super().__post_init__()
        receive = self.board.receive

        def noted(data: bytes, current: float) -> bytes:
            self.heard.append((current, data))
            return receive(data, current)

        self.board.receive = noted  # type: ignore[method-assign]


def board(seconds: int) -> None:
    """Drive two motors by what a board said: every byte, and a hundred ticks a second."""
    bricks = HeardBricks()
    bricks.until(bricks.ready)
    bricks.wanted = np.radians([300.0, 300.0])
    bricks.run(2 * SECONDS)
    driver = BoardDriver(bricks.spec.joints, BuildHatSettings(), BringUp())
    begin = bricks.now - 2 * SECONDS
    driver.opened(bricks.heard[0][0])
    due = bricks.heard[0][0]
    for current, data in bricks.heard:
        if current > begin + seconds:
            break
        driver.receive(data, current)
        if current >= due:
            driver.command(bricks.wanted, current)
            driver.tick(current)
            due = current + 0.01


PARTS_BY_NAME: dict[str, Part] = {
    "ticks": engine_part(pictures=False),
    "pictures": engine_part(pictures=True),
    "board": board,
    "sending": sending,
    "telemetry": telemetry,
    "camera": camera,
}


if __name__ == "__main__":
    plug_in(find_features())
    PARTS_BY_NAME[sys.argv[1]](int(sys.argv[2]))
