"""Benchmark of the growth of cost: with rays, particles, fields, pages, recordings and workers.

Each case runs in a process of its own, one after the other. What is measured is processor time and
memory, which other work on the machine changes less than time by the clock.
"""

from __future__ import annotations

import math
import multiprocessing
import random
import resource
import shutil
import tempfile
import time
from collections.abc import Callable, Mapping
from concurrent.futures import ProcessPoolExecutor
from contextlib import closing
from dataclasses import replace
from datetime import datetime
from itertools import pairwise
from pathlib import Path
from typing import TypeVar

from app.engine.build import build_program
from app.engine.program import LocalProgram
from app.features.recordings.contents import contents_of
from app.features.recordings.files.mcap_reader import open_recording
from app.features.recordings.files.recorded import RecordedMessage
from app.features.recordings.files.recording_file import RecordingFile
from app.features.recordings.recorder import Recorder
from app.features.ros.publisher import TopicPublisher
from app.features.ros.source import TopicSource
from app.features.ros.topics import Quality
from app.messages.driving_commands import FigureEightCommand
from app.settings.config import Config, with_settings
from benchmarks.driving import WARM_UP_S, drive, meanwhile, receive, share
from benchmarks.programs import server
from benchmarks.result import Result
from benchmarks.sweep import points_a_minute
from benchmarks.topics.recording import drive_for, driving_program

SECONDS = 8.0
"""Simulated time of each case [s]."""
RAYS = (91, 181, 361)
PARTICLES = (500, 2_000, 5_000, 20_000)
SIDES = (2, 8, 16, 30)
"""Sides of square floors [m]."""
FLOOR_PER_STROKE, LENGTH = 0.7, 500
"""Floor for each piece of tape [m²], and its length [mm]."""
LARGE = 4_000
"""Messages from this size on, pictures and particles, are not kept [bytes]."""
PAGES = (1, 10, 30, 100)
MINUTES = (1, 10, 60, 480)
WORKERS = (1, 2, 4, 8)
T = TypeVar("T")


def measure() -> Result:
    """Measure all growth; the case that comes first in each row is the usual one."""
    usual = {"scanner.rays": RAYS[0]} | _particles(PARTICLES[0])
    more: dict[str, float] = {}
    for rays in RAYS:
        more |= _lap(f"{rays} rays", usual | {"scanner.rays": rays})
    for particles in PARTICLES:
        more |= _lap(f"{particles} particles", usual | _particles(particles))
    with tempfile.TemporaryDirectory() as folder:
        for side in SIDES:
            drawing, strokes = _large_floor(Path(folder), side)
            more |= _lap(f"{side} m, {strokes} strokes", usual | {"map": drawing})
    more |= {f"{pages} pages [% of a core]": share for pages, share in _pages().items()}
    more |= _alone(_recordings)
    for workers in WORKERS:
        more[f"sweep, {workers} workers [points/min]"] = points_a_minute(workers)
    return Result(
        unit="ms of processor time a simulated second, 91 rays",
        brickpose=more[f"{RAYS[0]} rays [ms]"],
        more=more,
    )


def _particles(count: int) -> dict[str, int]:
    settings = "localization.filter.min_particles", "localization.filter.max_particles"
    return dict.fromkeys(settings, count)


def _lap(name: str, settings: Mapping[str, object]) -> dict[str, float]:
    """Return processor time a simulated second, and memory, with some settings."""
    spent, memory = _alone(_drive, settings)
    return {f"{name} [ms]": 1e3 * spent, f"{name} [MB]": memory}


def _alone(work: Callable[..., T], *given: object) -> T:
    """Do work in a new process."""
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(1, context) as pool:
        return pool.submit(work, *given).result()


def _drive(settings: Mapping[str, object]) -> tuple[float, float]:
    """Return processor time a simulated second [s], and the largest memory [MB]."""
    program = build_program(with_settings(Config(robot="kinematic", seed=3), settings))
    with closing(program.robot):
        _step(program, 1.0)  # load compiled code
        before = time.process_time()
        _step(program, SECONDS)
        spent = (time.process_time() - before) / SECONDS
    return spent, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def _step(program: LocalProgram, seconds: float) -> None:
    first = snapshot = program.engine.step()
    while snapshot.stamp < first.stamp + seconds:
        program.engine.commands.put(FigureEightCommand(type="figure_eight"))
        snapshot = program.engine.step()


def _large_floor(folder: Path, side: int) -> tuple[str, int]:
    """Draw a floor with pieces of tape at random; return its file and the number of pieces."""
    rng, strokes = random.Random(side), max(6, round(side * side / FLOOR_PER_STROKE))
    lines = []
    for _ in range(strokes):
        x, y = (rng.randrange(100, 1000 * side - 100 - LENGTH) for _ in "xy")
        along_x = rng.random() < 0.5
        end = (x + LENGTH, y) if along_x else (x, y + LENGTH)
        lines.append(f'<line x1="{x}" y1="{y}" x2="{end[0]}" y2="{end[1]}"/>')
    path, size = folder / f"floor_{side}.svg", 1000 * side
    path.write_text(
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{size}mm" height="{size}mm" '
        f'viewBox="0 0 {size} {size}" data-start="{size // 2} {-size // 2} 0">'
        f'<rect width="{size}" height="{size}" fill="#d7d5cf"/>'
        f'<g stroke="#202225" stroke-width="50" fill="none">{"".join(lines)}</g></svg>',
        encoding="utf-8",
    )
    return str(path), strokes


def _recordings() -> dict[str, float]:
    """Return what it costs to open recordings, to read a second in the middle, and to read all."""
    result: dict[str, float] = {}
    with tempfile.TemporaryDirectory() as folder:
        messages = _record(Path(folder) / "short")
        for minutes in MINUTES:
            path = _repeated(messages, minutes, Path(folder) / str(minutes))
            result |= {
                f"{minutes} min, {name} [ms]": 1e3 * spent
                for name, spent in _read(path, 60e9 * minutes).items()
            }
            shutil.rmtree(path)
    return result


def _record(folder: Path) -> list[RecordedMessage]:
    """Record a drive; return all but pictures and clouds of particles, in order."""
    config = Config(robot="kinematic", seed=3)
    config = replace(config, recording=replace(config.recording, folder=str(folder)))
    with driving_program(config) as program:
        publisher = TopicPublisher(TopicSource.of(program), program.engine.every)
        recorder = Recorder(publisher, config.recording, lambda: contents_of(program), datetime.now)
        recorder.start()
        drive_for(program, SECONDS)
        recorder.close()
        publisher.close()
    (path,) = folder.iterdir()
    everything = open_recording(path).messages()
    return [message for message in everything if len(message.cdr) < LARGE]


def _repeated(messages: list[RecordedMessage], minutes: int, folder: Path) -> Path:
    """Write messages again and again, until they last for so many minutes."""
    first, last = messages[0].log_time_ns, messages[-1].log_time_ns
    file, period = RecordingFile(folder), last - first + 20_000_000
    for turn in range(math.ceil(minutes * 60e9 / period)):
        for message in messages:
            stamp = message.log_time_ns - first + turn * period
            file.write(message.topic, message.type, Quality(), stamp, stamp, message.cdr)
    file.close()
    return folder


def _read(path: Path, length_ns: float) -> dict[str, float]:
    """Return processor time to open, to read a second in the middle, and to read odometry [s]."""
    stamps = [time.process_time()]
    reader = open_recording(path)
    stamps.append(time.process_time())
    middle = int(length_ns / 2)
    for message in reader.messages(None, middle):
        if message.log_time_ns > middle + 1e9:
            break
    stamps.append(time.process_time())
    sum(1 for _ in reader.messages({"/odom"}, 0))
    stamps.append(time.process_time())
    opened, sought, plotted = (after - before for before, after in pairwise(stamps))
    return {"open": opened, "go to the middle": sought, "read odometry": plotted}


def _pages() -> dict[int, float]:
    """Return the program's share of a core with so many pages, without the camera's stream [%]."""
    shares = {}
    with (
        server("--robot", "kinematic", "--map", "square", "--seed", "3") as running,
        meanwhile([drive(running.address)]),
    ):
        time.sleep(WARM_UP_S)
        for count in PAGES:
            live = f"ws://{running.address}/api/live?rate=30"
            with meanwhile([receive(live) for _ in range(count)]):
                shares[count] = share(running)
    return shares
