"""Benchmark of the start, with everything already compiled: time to the page, and memory."""

from __future__ import annotations

import time
import urllib.request

import numpy as np

from benchmarks.programs import server, telemetry
from benchmarks.result import Result

RUNS = 3

ROBOTS = ("kinematic", "sim")

TELEMETRY = 300
"""Messages after which all is loaded that a robot at rest needs."""


def measure() -> Result:
    """Measure the time from ``brickpose run`` to the first page, and to a robot that answers."""
    pages, robots = zip(*(_start() for _ in range(RUNS)), strict=True)
    return Result(
        unit="s to the first page",
        brickpose=float(np.median(pages)),
        more={
            "to the first telemetry [s]": float(np.median(robots)),
            **{f"memory, {robot} [MB]": _memory_mb(robot) for robot in ROBOTS},
        },
    )


def _start() -> tuple[float, float]:
    start = time.perf_counter()
    with server() as running:
        _wait_for(running.url + "/")
        page = time.perf_counter() - start
        _wait_for(running.url + "/api/state")
        return page, time.perf_counter() - start


def _memory_mb(robot: str) -> float:
    """Memory of a program that stands, with nobody at its page [MB]."""
    with server("--robot", robot) as running:
        with running.live() as live:
            for _ in range(TELEMETRY):
                telemetry(live)
        return running.memory_mb()


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
