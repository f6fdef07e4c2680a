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
"""A few viewers; and those of a class, all at one robot."""
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
        _watch(address, pace, CLASS)
        by_class = percentile_ms(pace, 99)
        watched = _watch(address, pace, VIEWERS)
    return Result(
        unit="ms p99 step with 5 viewers",
        brickpose=percentile_ms(pace, 99),
        peer={"without viewers": alone, f"with {CLASS} viewers": by_class},
        more={"median step [ms]": percentile_ms(pace, 50), **watched},
    )


def _watch(address: str, pace: RealTime, count: int) -> dict[str, float]:
    module = "benchmarks.viewers", address, str(count), str(SECONDS)
    command = [sys.executable, "-m", *module]
    with subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, text=True) as viewers:
        assert viewers.stdout is not None
        viewers.stdout.readline()  # wait until all are connected
        pace.busy.clear()
        counted: dict[str, float] = json.loads(viewers.stdout.readline())
    return counted
