"""Benchmark of a recording: processor time and disk space."""

from __future__ import annotations

import statistics
import tempfile
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from datetime import datetime
from pathlib import Path

from app.engine.build import build_program
from app.engine.engine_thread import EngineThread
from app.engine.program import Program
from app.features.recordings.contents import contents_of
from app.features.recordings.recorder import Recorder
from app.features.ros.publisher import TopicPublisher
from app.features.ros.source import TopicSource
from app.messages.driving_commands import FigureEightCommand
from app.settings.config import Config
from benchmarks.result import Result
from sim.real_time import RealTime

SECONDS = 6.0
ROUNDS = 5
WARM_UP_S = 8.0
"""Time to load compiled code and to get past the first large clouds."""

THREADS = ("topics", "recording")


@dataclass(frozen=True, slots=True)
class _Use:
    """Processor time over some seconds."""

    process: float
    """Of the whole program [% of a core]."""
    threads: float
    """Of the threads that record [% of a core]."""


def measure() -> Result:
    """Measure pictures at 15 Hz and all other topics, on the figure-eight in real time.

    Rounds with and without a recording alternate, so that both see the same machine load. The
    smallest round counts: other work on the machine can only add time.
    """
    config = Config(robot="sim")
    with tempfile.TemporaryDirectory() as folder:
        config = replace(config, recording=replace(config.recording, folder=folder))
        with driving_program(config) as program:
            publisher = TopicPublisher(TopicSource.of(program), program.engine.every)
            recorder = Recorder(
                publisher, config.recording, lambda: contents_of(program), datetime.now
            )
            drive_for(program, WARM_UP_S)
            without, recording = [], []
            for _ in range(ROUNDS):
                without.append(_used(program))
                recorder.start()
                drive_for(program, 1.0)  # the data that is written only once is now written
                recording.append(_used(program))
                recorder.close()
            publisher.close()
        size = _megabytes_a_minute(Path(folder))
    return Result(
        unit="% of a core",
        brickpose=min(use.threads for use in recording),
        more={
            "program without a recording [% of a core]": min(use.process for use in without),
            "program with a recording [% of a core]": min(use.process for use in recording),
            "disk [MB a minute]": size,
        },
    )


@contextmanager
def driving_program(config: Config) -> Iterator[Program]:
    """Run a program in real time, in a thread of its own, until the block ends."""
    program = build_program(config, RealTime())
    thread = EngineThread(program.engine)
    thread.start()
    try:
        yield program
    finally:
        thread.stop()


def drive_for(program: Program, seconds: float) -> None:
    """Drive the figure-eight for some time [s]."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        program.engine.commands.put(FigureEightCommand(type="figure_eight"))
        time.sleep(0.1)


def _used(program: Program) -> _Use:
    begin, process, threads = time.monotonic(), time.process_time(), _threads_time()
    drive_for(program, SECONDS)
    passed = time.monotonic() - begin
    return _Use(
        100 * (time.process_time() - process) / passed,
        100 * (_threads_time() - threads) / passed,
    )


def _threads_time() -> float:
    """Return the processor time of the threads that record [s]."""
    idents = [thread.ident for thread in threading.enumerate() if thread.name in THREADS]
    clocks = [time.pthread_getcpuclockid(ident) for ident in idents if ident is not None]
    return sum(time.clock_gettime(clock) for clock in clocks)


def _megabytes_a_minute(folder: Path) -> float:
    """Return the size per minute, including what each recording holds once.

    A longer recording has a smaller share of that.
    """
    sizes = [path.stat().st_size for path in folder.rglob("*.mcap")]
    return statistics.median(sizes) / 1e6 / (SECONDS + 1.0) * 60
