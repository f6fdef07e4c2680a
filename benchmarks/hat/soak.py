"""Soak test: ten minutes of random faults; the robot must stop, and then recover by itself.

The program drives on the emulated board while motors are unplugged, wheels are blocked, the supply
sags, bytes are garbled, and the board falls silent or restarts.
"""

from __future__ import annotations

import json
import tempfile
import time
from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from websockets.sync.connection import Connection

from benchmarks.hat.emulated_hat import EmulatedHat
from benchmarks.hat.programs import robot_in_bricks
from benchmarks.programs import START_S, connected, estimated, telemetry, until
from benchmarks.result import Result

MINUTES = 10.0
SEED = 0
DRIVE = {"type": "drive", "v": 0.1, "omega": 0.9}
"""Circles of 0.11 m."""

STOP_S = 0.5
BACK_S = 45.0
"""Longest time to recover [s]: a restart with an upload and slow motors takes longest."""

TURNING = 100.0
"""Both wheels are faster than this when the robot drives [degree/s]."""


@dataclass(frozen=True)
class Fault:
    """A fault of a board, with the commands that begin and end it."""

    name: str
    begin: str
    end: str | None
    stops: bool = True
    """Whether the motors must stop."""


TROUBLES = (
    Fault("left motor unplugged", "unplug A", "plug A"),
    Fault("right motor unplugged", "unplug B", "plug B"),
    Fault("wheel blocked", "stall B", "free B"),
    Fault("motor power fault", "fault motor on", "fault motor off"),
    Fault("port power fault", "fault port on", "fault port off"),
    Fault("low supply", "supply 5.6", "supply 8"),
    Fault("supply over 10 V", "supply 10.1", "supply 8", stops=False),
    Fault("silent board", "silent on", "silent off"),
    Fault("board restarts", "reset", None),
    Fault("noise from the board", "garble 0.003", "garble 0", stops=False),
    Fault("garbled bytes to the board", "garble-in 0.0005", "garble-in 0", stops=False),
    Fault("bytes lost to the board", "lose 0.001", "lose 0", stops=False),
    Fault("slow main loop", "late 20", None, stops=False),
)


def measure() -> Result:
    """Count the faults that the program survives in ten minutes."""
    return soak(60 * MINUTES)


def soak(seconds: float) -> Result:
    """Cause random faults for some time [s]."""
    with (
        tempfile.TemporaryDirectory() as folder,
        robot_in_bricks(Path(folder), SEED) as (hat, program),
        program.live() as live,
    ):
        until(live, connected, START_S)
        until(live, estimated, START_S)
        _drive_until_turning(live, hat)
        before = program.threads(), program.descriptors()
        stops, backs, counts = _inject_faults(live, hat, seconds)
        _drive_until_turning(live, hat)
        after = program.threads(), program.descriptors()
    return Result(
        unit="troubles survived, of all",
        brickpose=float(len(backs)),
        more={
            "stopped after, worst [s]": max(stops),
            "drives again after the cure, median [s]": float(np.median(backs)),
            "drives again after the cure, worst [s]": max(backs),
            "threads more than before": after[0] - before[0],
            "descriptors more than before": after[1] - before[1],
            **{f"times {name}": count for name, count in sorted(counts.items())},
        },
    )


def _inject_faults(
    live: Connection, hat: EmulatedHat, seconds: float
) -> tuple[list[float], list[float], Counter[str]]:
    rng = np.random.default_rng(SEED)
    stops, backs = [0.0], []
    counts: Counter[str] = Counter()
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        trouble = TROUBLES[rng.integers(len(TROUBLES))]
        counts[trouble.name] += 1
        begin, _ = hat.motors()
        hat.ask(trouble.begin)
        if trouble.stops:
            stops.append(_time_to_stop(live, hat, begin, trouble))
        _drive_for(live, float(rng.uniform(0.2, 3.0)))
        if trouble.end is not None:
            hat.ask(trouble.end)
        cured = time.monotonic()
        _drive_until_turning(live, hat)
        backs.append(time.monotonic() - cured)
        _drive_for(live, float(rng.uniform(0.2, 2.0)))
    return stops, backs, counts


def _time_to_stop(live: Connection, hat: EmulatedHat, begin: float, trouble: Fault) -> float:
    """Return the time until both wheels stand, while the program is commanded to drive [s]."""
    while True:
        _drive(live)
        stamp, speeds = hat.motors()
        if max(speeds) < 5:
            return stamp - begin
        if stamp - begin > 10 * STOP_S:
            raise RuntimeError(f"{trouble.name}: the motors go on")


def _drive_until_turning(live: Connection, hat: EmulatedHat) -> None:
    deadline = time.monotonic() + BACK_S
    while min(hat.motors()[1]) < TURNING:
        message = _drive(live)
        if time.monotonic() > deadline:
            raise TimeoutError(
                f"it does not drive again: {message['problems']}, {hat.ask('state')}"
            )


def _drive_for(live: Connection, seconds: float) -> None:
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        _drive(live)


def _drive(live: Connection) -> dict[str, Any]:
    live.send(json.dumps(DRIVE))
    return telemetry(live)
