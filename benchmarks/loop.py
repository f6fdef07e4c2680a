"""Benchmark of the program's loop against real time: physics, picture, scan and filter."""

from __future__ import annotations

import time
from dataclasses import replace

from app.engine.build import build_program
from app.engine.program import LocalProgram
from app.messages.driving_commands import FigureEightCommand
from app.settings.config import Config
from benchmarks.result import Result
from robot.errors import PackageError
from robot.localization.parameters import FilterParameters, LocalizationParameters
from sim.engines import ENGINES, choose_engine
from sim.floor_camera import CameraSettings
from sim.simulated import SimSettings

SECONDS = 16.0
"""Simulated time: one lap of the figure-eight."""

RUNS = 3


def measure() -> Result:
    """Measure 640 x 480 px at 15 frames/s, 500 particles, without pacing, by both engines."""
    engines = {engine: _lap(engine) for engine in ENGINES if _is_installed(engine)}
    default = choose_engine()
    wall, cpu = engines.pop(default)
    others = {f"with {engine}": SECONDS / other[0] for engine, other in engines.items()}
    return Result(
        unit=f"x real time, with {default}",
        brickpose=SECONDS / wall,
        peer={"real time": 1.0} | others,
        more={f"CPU seconds a simulated second, with {default}": cpu / SECONDS}
        | {f"with {engine}": other[1] / SECONDS for engine, other in engines.items()},
    )


def _is_installed(engine: str) -> bool:
    try:
        choose_engine(engine)
    except PackageError:
        return False
    return True


def _lap(engine: str) -> tuple[float, float]:
    """Return the median wall and processor time of a lap [s]."""
    particles = FilterParameters(min_particles=500, max_particles=500)
    config = Config(
        robot="sim",
        sim=SimSettings(engine=engine, camera=CameraSettings(frame_rate=15)),
        localization=replace(LocalizationParameters(), filter=particles),
    )
    walls, cpus = [], []
    for seed in range(RUNS):
        program = build_program(replace(config, seed=seed))
        _drive(program, 1.0)  # load compiled code
        wall, cpu = time.perf_counter(), time.process_time()
        _drive(program, SECONDS)
        walls.append(time.perf_counter() - wall)
        cpus.append(time.process_time() - cpu)
        program.robot.close()
    return sorted(walls)[RUNS // 2], sorted(cpus)[RUNS // 2]


def _drive(program: LocalProgram, seconds: float) -> None:
    first = program.engine.step()
    snapshot = first
    while snapshot.stamp < first.stamp + seconds:
        program.engine.commands.put(FigureEightCommand(type="figure_eight"))
        snapshot = program.engine.step()
