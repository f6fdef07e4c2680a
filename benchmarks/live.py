"""Benchmark of the engine's step time in real time, with five viewers."""

from __future__ import annotations

import json
import subprocess
import sys
import time

from app.settings.config import ROOT
from benchmarks.result import Result
from benchmarks.served_simulation import percentile_ms, served_simulation
from sim.real_time import RealTime

VIEWERS = 5
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
        watched = _watch(address, pace)
    return Result(
        unit="ms p99 step with 5 viewers",
        brickpose=percentile_ms(pace, 99),
        peer={"without viewers": alone},
        more={"median step [ms]": percentile_ms(pace, 50), **watched},
    )


def _watch(address: str, pace: RealTime) -> dict[str, float]:
    command = [sys.executable, "-m", "benchmarks.viewers", address, str(VIEWERS), str(SECONDS)]
    with subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, text=True) as viewers:
        assert viewers.stdout is not None
        viewers.stdout.readline()  # wait until all are connected
        pace.busy.clear()
        counted: dict[str, float] = json.loads(viewers.stdout.readline())
    return counted
