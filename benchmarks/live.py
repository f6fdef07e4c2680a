"""Benchmark of the engine's step time in real time, with five viewers."""

from __future__ import annotations

import json
import subprocess
import sys
import threading
import time

import numpy as np

from app.engine.build import build_program
from app.page.listening import listen
from app.page.serving import Server
from app.settings.config import ROOT, Config
from benchmarks.result import Result
from sim.real_time import RealTime

VIEWERS = 5
SECONDS = 15.0


def measure() -> Result:
    """Measure the 99th percentile of the step time, with simulation, with and without viewers.

    A viewer receives everything that the page receives: telemetry, pictures and the messages of the
    3D view. The first viewer drives the figure-eight. Viewers run on this machine, too.
    """
    pace = RealTime()
    program = build_program(Config(robot="sim"), pace)
    listening = listen("127.0.0.1", 0)
    address = f"127.0.0.1:{listening.getsockname()[1]}"
    server = Server(program)
    thread = threading.Thread(target=server.run, args=(listening,), name="server")
    thread.start()
    try:
        time.sleep(5.0)  # wait: compiled code is loaded, and the first clouds are large
        pace.busy.clear()
        time.sleep(SECONDS)
        alone = _percentile_ms(pace, 99)
        watched = _watch(address, pace)
    finally:
        server.stop()
        thread.join(10)
    return Result(
        unit="ms p99 step with 5 viewers",
        brickpose=_percentile_ms(pace, 99),
        peer={"without viewers": alone},
        more={"median step [ms]": _percentile_ms(pace, 50), **watched},
    )


def _watch(address: str, pace: RealTime) -> dict[str, float]:
    command = [sys.executable, "-m", "benchmarks.viewers", address, str(VIEWERS), str(SECONDS)]
    with subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, text=True) as viewers:
        assert viewers.stdout is not None
        viewers.stdout.readline()  # wait until all are connected
        pace.busy.clear()
        counted: dict[str, float] = json.loads(viewers.stdout.readline())
    return counted


def _percentile_ms(pace: RealTime, percent: float) -> float:
    return 1e3 * float(np.percentile(list(pace.busy), percent))
