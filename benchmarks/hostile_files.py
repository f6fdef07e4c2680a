"""Benchmark of how late the control loop is while a hostile file is read, and without.

The files are read as the page has them read, in a process of its own: a drawing whose pattern holds
Python's lock for ever, one of dense curves, a recording with such a drawing in it, and one file
that wants all memory.
"""

from __future__ import annotations

import re
import tempfile
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from datetime import datetime
from functools import partial
from pathlib import Path

import numpy as np

from app.engine.build import build_program
from app.features.recordings.attachments import Contents
from app.features.recordings.contents import contents_of
from app.features.recordings.recorder import Recorder
from app.features.recordings.replay.opening import Opened
from app.features.ros.publisher import TopicPublisher
from app.features.ros.source import TopicSource
from app.foreign_files import read_apart
from app.messages.driving_commands import FigureEightCommand
from app.settings.config import MAPS, Config
from benchmarks.result import Result
from benchmarks.served_simulation import Ticks, in_a_thread, served_simulation
from robot.errors import BrickPoseError
from robot.fields.field import Field
from robot.fields.field_loading import load_field
from sim.real_time import RealTime
from sim.simulated import PERIOD

TURNS = 5
SECONDS = 5.0
READING_S = 3.0
"""The file is being read for so long before steps are measured: its process has begun [s]."""
CURVES = 20_000
"""Curves of the dense drawing, which has nearly as many bytes as a drawing may have."""
RECORDED_S = 2.0
PATIENCE_S = READING_S + SECONDS + 1
"""A file's clock is set shorter than the page's, so that a turn ends soon [s]."""


def never_read(path: Path) -> object:
    """Look for a pattern for some thousand years."""
    return re.match(r"(a+)+$", "a" * 60 + path.suffix)


def swallow(path: Path) -> list[list[int]]:
    """Take all memory that is there."""
    kept: list[list[int]] = []
    while path:
        kept.append([0] * 1_000_000)
    return kept


def draw(path: Path) -> Field:
    """Load a drawing."""
    return load_field(str(path), MAPS)


def measure() -> Result:
    """Measure the 99th percentile of a tick's delay while each file is read, and without, in turns.

    The median of the turns counts, as other programs disturb some.
    """
    with tempfile.TemporaryDirectory() as folder:
        files = _files(Path(folder))
        with served_simulation() as (_, ticks, _):
            times = {name: _in_turns(read, ticks) for name, read in files.items()}
    more = {
        f"{name}, {case} [ms]": value
        for name, cases in times.items()
        for case, value in zip(("with", "without"), cases, strict=True)
    }
    worst = max(times.values(), key=lambda cases: cases[0] - cases[1])
    return Result(
        unit="ms p99 delay of a tick while the worst file is read",
        brickpose=worst[0],
        peer={"without": worst[1]},
        more=more,
    )


def _files(folder: Path) -> dict[str, Callable[[], object]]:
    """Return what reads each hostile file once, as the page does."""
    drawing = folder / "curves.svg"
    drawing.write_text(_dense_curves(), encoding="utf-8")
    recording = _recorded(folder, drawing)
    return {
        "a pattern that never ends": partial(read_apart, never_read, drawing, PATIENCE_S),
        "a drawing of dense curves": partial(read_apart, draw, drawing, PATIENCE_S),
        "a recording with that drawing": partial(read_apart, Opened.of, recording, PATIENCE_S),
        "all memory": partial(read_apart, swallow, drawing, PATIENCE_S),
    }


def _dense_curves() -> str:
    curves = " q 40 9 80 0 q 40 9 -80 60" * (CURVES // 2)
    return (
        '<svg xmlns="http://www.w3.org/2000/svg" width="2000mm" height="1000mm" '
        'viewBox="-1000 -500 2000 1000">'
        f'<path d="M -900 0{curves}" fill="none" stroke="#222" stroke-width="30"/></svg>'
    )


def _recorded(folder: Path, drawing: Path) -> Path:
    """Record a robot, and put another drawing into the recording."""
    settings = replace(Config().recording, folder=str(folder / "recordings"))
    program = build_program(Config(robot="kinematic", recording=settings))

    def contents() -> Contents:
        real = contents_of(program)
        data = drawing.read_bytes()
        return replace(
            real,
            attachments=tuple(
                replace(each, data=data) if each.name.endswith(".svg") else each
                for each in real.attachments
            ),
        )

    publisher = TopicPublisher(TopicSource.of(program), program.engine.every)
    recorder = Recorder(publisher, settings, contents, datetime.now)
    try:
        made = recorder.start()
        pace = RealTime()
        for tick in range(round(RECORDED_S / PERIOD)):
            program.engine.commands.put(FigureEightCommand(type="figure_eight"))
            program.engine.step()
            pace(tick * PERIOD)
    finally:
        recorder.close()
        publisher.close()
        program.robot.close()
    return made


def _in_turns(read: Callable[[], object], ticks: Ticks) -> tuple[float, float]:
    """Return p99 while a file is read again and again, and without [ms]."""
    present: list[float] = []
    alone: list[float] = []
    for _ in range(TURNS):
        time.sleep(1.0)
        alone.append(ticks.percentile_ms(99, SECONDS))
        with in_a_thread(partial(_tried, read)):
            time.sleep(READING_S)
            present.append(ticks.percentile_ms(99, SECONDS))
    return float(np.median(present)), float(np.median(alone))


def _tried(read: Callable[[], object]) -> None:
    with suppress(BrickPoseError):
        read()
