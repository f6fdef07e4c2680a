"""Benchmark of the control step while a map is drawn of the floor, and without."""

from __future__ import annotations

import time

import numpy as np

from app.engine.build import build_program
from app.engine.program import LocalProgram
from app.features.mapping.map_drawer import MapDrawer
from app.messages.driving_commands import FigureEightCommand
from app.settings.config import Config
from benchmarks.result import Result
from robot.driving.figure_eight import FigureEight
from sim.real_time import RealTime
from sim.simulated import PERIOD

LAPS = 3
"""Without a map, and while one is drawn, in turns."""
LONGEST_S = 60.0
"""The adjustment after a lap is waited for so long [s]."""


def measure() -> Result:
    """Measure the 99th percentile of a step, lap by lap at the robot's pace, and the correction.

    The step's time on the processor counts, as other programs do not disturb it; its time on the
    clock is told beside. The medians of the laps count.
    """
    with_map, without, corrections = [], [], []
    pace = RealTime()
    program = build_program(Config(robot="kinematic"), pace)
    try:
        _lap(program, pace)  # load compiled code
        for _ in range(LAPS):
            without.append(_lap(program, pace))
            drawer = MapDrawer(program)
            drawer.begin()
            try:
                with_map.append(_lap(program, pace))
                _until_drawn(program, drawer)
                corrections.append(_correction(program, drawer))
            finally:
                drawer.close()
    finally:
        program.robot.close()
    (step, clock), (step_without, clock_without) = (
        np.median(laps, axis=0).tolist() for laps in (with_map, without)
    )
    return Result(
        unit="ms p99 step while a map is drawn",
        brickpose=step,
        peer={"without": step_without},
        more={
            "by the clock, with [ms]": clock,
            "by the clock, without [ms]": clock_without,
            "correction of the whole map after a lap [s]": float(np.median(corrections)),
        },
    )


def _lap(program: LocalProgram, pace: RealTime) -> tuple[float, float]:
    """Drive a lap; return p99 of the step on the processor, and by the clock [ms]."""
    pace.busy.clear()
    times = []
    for _ in range(round(FigureEight().lap / PERIOD)):
        program.engine.commands.put(FigureEightCommand(type="figure_eight"))
        began = time.thread_time()
        program.engine.step()
        times.append(time.thread_time() - began)
    return 1e3 * float(np.percentile(times, 99)), 1e3 * float(np.percentile(list(pace.busy), 99))


def _until_drawn(program: LocalProgram, drawer: MapDrawer) -> None:
    """Go on until something is drawn: on a busy machine that may take longer than a lap."""
    while (drawing := drawer.drawing) is not None and drawing.state == "draw":
        if drawing.sketch is not None:
            return
        program.engine.step()


def _correction(program: LocalProgram, drawer: MapDrawer) -> float:
    """Finish a map while the program goes on; return how long its adjustment takes [s]."""
    began = time.perf_counter()
    drawer.finish()
    while (drawing := drawer.drawing) is not None and drawing.state in ("draw", "finish"):
        if time.perf_counter() > began + LONGEST_S:
            raise RuntimeError(f"the map was not finished within {LONGEST_S:g} s")
        program.engine.step()
    if drawing is None or drawing.state != "done":
        raise RuntimeError("the map failed" if drawing is None else f"the map: {drawing.words}")
    return time.perf_counter() - began
