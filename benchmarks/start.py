"""Benchmark of the start, from the command to the page, with everything already compiled."""

from __future__ import annotations

import time
import urllib.request

import numpy as np

from benchmarks.programs import server
from benchmarks.result import Result

RUNS = 3


def measure() -> Result:
    """Measure the time from ``brickpose run`` to the first page, and to a robot that answers."""
    pages, robots = zip(*(_start() for _ in range(RUNS)), strict=True)
    return Result(
        unit="s to the first page",
        brickpose=float(np.median(pages)),
        more={"to the first telemetry [s]": float(np.median(robots))},
    )


def _start() -> tuple[float, float]:
    start = time.perf_counter()
    with server() as running:
        _wait_for(running.url + "/")
        page = time.perf_counter() - start
        _wait_for(running.url + "/api/state")
        return page, time.perf_counter() - start


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
