"""Soak test: random faults for as long as asked; the robot recovers by itself and uses no more.

The program drives on the emulated board while motors are unplugged, wheels are blocked, the supply
sags, bytes are garbled, the board falls silent or restarts; while the camera is unplugged, viewers
come, hang and are killed, the process of ROS 2 is killed, recordings begin, end and fill the disk.
"""

from __future__ import annotations

import json
import sys
import tempfile
import time
from collections import defaultdict
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.faults.rig import Rig, rig
from benchmarks.faults.troubles import TROUBLES, Trouble
from benchmarks.programs import START_S, ServedProgram, connected, estimated, telemetry, until
from benchmarks.result import Result

SEED = 0
DRIVE = {"type": "drive", "v": 0.1, "omega": 0.9}
"""Circles of 0.11 m."""

STOP_S = 0.5
BACK_S = 45.0
"""Longest time to recover [s]: a restart with an upload and slow motors takes longest."""

TURNING = 100.0
"""Both wheels are faster than this when the robot drives [degree/s]."""

WARM_UP_S = 60.0
"""What a program uses after this time counts as its usual use."""


@dataclass
class Record:
    """What a soak has seen."""

    stops: list[float] = field(default_factory=lambda: [0.0])
    """Times until the motors stood [s]; 0 where none had to stop."""
    backs: defaultdict[str, list[float]] = field(default_factory=lambda: defaultdict(list))
    """Times from the end of each kind of fault until the robot drove again [s]."""
    steps: list[float] = field(default_factory=list)
    """The engine's work in a step since the last line of the table [ms]."""


@dataclass(frozen=True)
class ProgramUsage:
    """What a program uses at one moment."""

    minute: float
    memory_mb: float
    threads: int
    descriptors: int

    @classmethod
    def of(cls, program: ServedProgram, minute: float) -> ProgramUsage:
        """Look at a running program."""
        return cls(minute, program.memory_mb(), program.threads(), program.descriptors())


def measure(minutes: float = 10.0) -> Result:
    """Count the faults that the program survives, and print what it uses each minute.

    Raises:
        TimeoutError: the robot does not drive again after a fault.
        RuntimeError: its motors go on where they must stop.
    """
    with tempfile.TemporaryDirectory() as folder, rig(Path(folder), SEED) as running:
        until(running.live, connected, START_S)
        until(running.live, estimated, START_S)
        record = Record()
        _drive_until_turning(running, record)
        usage = _cause_troubles(running, record, 60 * minutes)
    return _result(record, usage)


def _cause_troubles(rig: Rig, record: Record, seconds: float) -> list[ProgramUsage]:
    rng = np.random.default_rng(SEED)
    begun = time.monotonic()
    usage: list[ProgramUsage] = []
    _say("minute  memory [MB]  threads  descriptors  step, median and 99 % [ms]")
    # Each kind once, then again in another order.
    kinds = [trouble for trouble in TROUBLES if rig.disk or not trouble.needs_disk]
    order: list[Trouble] = []
    while (elapsed := time.monotonic() - begun) < seconds or not usage:
        order = order or [kinds[index] for index in rng.permutation(len(kinds))]
        _survive(rig, order.pop(), rng, record)
        if elapsed >= WARM_UP_S * (len(usage) + 1):
            usage.append(ProgramUsage.of(rig.program, elapsed / 60))
            _say_usage(usage[-1], record)
    return usage


def _survive(rig: Rig, trouble: Trouble, rng: np.random.Generator, record: Record) -> None:
    begin, _ = rig.hat.motors()
    trouble.begin(rig)
    if trouble.stops:
        record.stops.append(_time_to_stop(rig, begin, trouble, record))
    _drive_for(rig, float(rng.uniform(0.2, 3.0)), record)
    if trouble.end is not None:
        trouble.end(rig)
    cured = time.monotonic()
    _drive_until_turning(rig, record)
    record.backs[trouble.name].append(time.monotonic() - cured)
    _drive_for(rig, float(rng.uniform(0.2, 2.0)), record)


def _time_to_stop(rig: Rig, begin: float, trouble: Trouble, record: Record) -> float:
    """Return the time until both wheels stand, while the program is commanded to drive [s]."""
    while True:
        _drive(rig, record)
        stamp, speeds = rig.hat.motors()
        if max(speeds) < 5:
            return stamp - begin
        if stamp - begin > 10 * STOP_S:
            raise RuntimeError(f"{trouble.name}: the motors go on")


def _drive_until_turning(rig: Rig, record: Record) -> None:
    deadline = time.monotonic() + BACK_S
    while min(rig.hat.motors()[1]) < TURNING:
        message = _drive(rig, record)
        if time.monotonic() > deadline:
            state = rig.hat.ask("state")
            raise TimeoutError(f"it does not drive again: {message['problems']}, {state}")


def _drive_for(rig: Rig, seconds: float, record: Record) -> None:
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        _drive(rig, record)


def _drive(rig: Rig, record: Record) -> dict[str, Any]:
    rig.live.send(json.dumps(DRIVE))
    message = telemetry(rig.live)
    record.steps.append(message["loop"]["step_ms"])
    return message


def _result(record: Record, usage: list[ProgramUsage]) -> Result:
    backs = [time for times in record.backs.values() for time in times]
    first, last = usage[0], usage[-1]
    worst = {
        f"drives again after: {name} ({len(times)} times), worst [s]": max(times)
        for name, times in sorted(record.backs.items())
    }
    return Result(
        unit="troubles survived",
        brickpose=float(len(backs)),
        more={
            "stopped after, worst [s]": max(record.stops),
            "drives again after the cure, median [s]": float(np.median(backs)),
            "memory more than after the first minute [MB]": last.memory_mb - first.memory_mb,
            "threads more than after the first minute": last.threads - first.threads,
            "descriptors more than after the first minute": last.descriptors - first.descriptors,
            **worst,
        },
    )


def _say_usage(usage: ProgramUsage, record: Record) -> None:
    median, most = np.percentile(record.steps, (50, 99))
    record.steps.clear()
    figures = f"{usage.memory_mb:11.1f}  {usage.threads:7d}  {usage.descriptors:11d}"
    _say(f"{usage.minute:6.1f}  {figures}  {median:.1f}, {most:.1f}")


def _say(line: str) -> None:
    sys.stdout.write(line + "\n")
    sys.stdout.flush()
