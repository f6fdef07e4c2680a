"""Benchmark of the engine's step time in real time, with viewers."""

from __future__ import annotations

import json
import subprocess
import sys
import time

from app.settings.config import ROOT
from benchmarks.result import Result
from benchmarks.served_simulation import percentile_ms, served_simulation
from sim.real_time import RealTime

VIEWERS, CLASS = 5, 30
"""Viewers that receive all they can; and pupils of a class, whose browsers are slow."""
SLOW_HZ = 10.0
FULL_HZ = 1000.0
"""Messages that a slow viewer takes a second; and one that takes all."""
SECONDS = 15.0


def measure() -> Result:
    """Measure the 99th percentile of the step time, with simulation, with and without viewers.

    A viewer receives everything that the page receives: telemetry, pictures and the messages of the
    3D view. The first viewer drives the figure-eight. Viewers run on this machine, too.
    """
    with served_simulation() as (address, pace):
        pace.busy.clear()
        time.sleep(SECONDS)
        alone = percentile_ms(pace, 99)
        _watch(address, pace, CLASS, SLOW_HZ)
        by_class = percentile_ms(pace, 99)
        watched = _watch(address, pace, VIEWERS, FULL_HZ)
    return Result(
        unit="ms p99 step with 5 viewers",
        brickpose=percentile_ms(pace, 99),
        peer={"without viewers": alone, f"with {CLASS} viewers at {SLOW_HZ:g} Hz": by_class},
        more={"median step [ms]": percentile_ms(pace, 50), **watched},
    )


def _watch(address: str, pace: RealTime, count: int, hertz: float) -> dict[str, float]:
    module = "benchmarks.viewers", address, str(count), str(SECONDS), str(hertz)
    command = [sys.executable, "-m", *module]
    with subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, text=True) as viewers:
        assert viewers.stdout is not None
        viewers.stdout.readline()  # wait until all are connected
        pace.busy.clear()
        counted: dict[str, float] = json.loads(viewers.stdout.readline())
    return counted
