"""Benchmark of a start with everything compiled, and of what a robot costs that stands."""

from __future__ import annotations

import time
import urllib.request

import numpy as np

from benchmarks.programs import server, telemetry
from benchmarks.result import Result

RUNS = 3

ROBOTS = ("kinematic", "sim")

STANDS_S = 20.0
"""Time for which a robot at rest is watched [s]."""
TELEMETRY = 300
"""Messages after which all is loaded that a robot at rest needs."""


def measure() -> Result:
    """Measure ``brickpose run`` up to the first page and to a robot that answers; then at rest."""
    pages, processor, robots = zip(*(_start() for _ in range(RUNS)), strict=True)
    resting = {robot: _at_rest(robot) for robot in ROBOTS}
    return Result(
        unit="s to the first page",
        brickpose=float(np.median(pages)),
        more={
            "to the first page, of a processor [s]": float(np.median(processor)),
            "to the first telemetry [s]": float(np.median(robots)),
            **{f"memory, {robot} [MB]": memory for robot, (memory, _) in resting.items()},
            **{f"share of a core, {robot} [%]": share for robot, (_, share) in resting.items()},
        },
    )


def _start() -> tuple[float, float, float]:
    """Return the time to the page by the clock and of a processor, and to a robot [s]."""
    start = time.perf_counter()
    with server() as running:
        _wait_for(running.url + "/")
        page, processor = time.perf_counter() - start, running.processor_seconds()
        _wait_for(running.url + "/api/state")
        return page, processor, time.perf_counter() - start


def _at_rest(robot: str) -> tuple[float, float]:
    """Memory [MB] and share of a core [%] of a robot that stands, with nobody at its page."""
    with server("--robot", robot) as running:
        with running.live() as live:
            for _ in range(TELEMETRY):
                telemetry(live)
        time.sleep(2.0)  # until the last viewer's work is done, and the camera rests
        before, start = running.processor_seconds(), time.perf_counter()
        time.sleep(STANDS_S)
        share = (running.processor_seconds() - before) / (time.perf_counter() - start)
        return running.memory_mb(), 100 * share


def _wait_for(address: str) -> None:
    deadline = time.perf_counter() + 120
    while True:
        try:
            with urllib.request.urlopen(address, timeout=120):
                return
        except OSError:
            # The server does not listen yet, or answers 503 before the first tick.
            if time.perf_counter() > deadline:
                raise
            time.sleep(0.02)
