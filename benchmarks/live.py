"""Live benchmark: how late the control loop is, beside all that a server does.

Both forms are measured in one run: control in a process of its own, and in the one that serves.
"""

from __future__ import annotations

import json
import re
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from functools import partial
from io import BytesIO

import numpy as np
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure

from app.engine.program import Program
from app.features.mapping.map_drawer import MapDrawer
from app.settings.config import ROOT
from benchmarks.result import Result
from benchmarks.served_simulation import Ticks, in_a_thread, served_simulation

VIEWERS, CLASS = 5, 30
"""A few viewers; and those of a class, all at one robot."""
SECONDS = 10.0
TURNS = 3
"""The median of so many turns counts, as other programs disturb some."""
PATTERN = re.compile(r"(a+)+$"), "a" * 24 + "b"
"""A pattern of a stranger's that holds Python's lock for a second each time."""

Disturbance = Callable[[], AbstractContextManager[object]]


def measure() -> Result:
    """Measure how late ticks are, in the 99th percentile, with each disturbance and without.

    A viewer receives everything that the page receives: telemetry, pictures and the messages of the
    3D view. Viewers run on this machine, too; all others are threads of the serving process.
    """
    apart, rates = _in_turns(one_process=False)
    joined, _ = _in_turns(one_process=True)
    more = {f"{name}, two processes [ms]": value for name, value in apart.items()}
    more |= {f"{name}, one process [ms]": value for name, value in joined.items()}
    few = f"{VIEWERS} viewers"
    return Result(
        unit=f"ms p99 delay of a tick with {few}, control in a process of its own",
        brickpose=apart[few],
        peer={"without viewers": apart["nothing"], f"with {few}, in one process": joined[few]},
        more={**more, **rates},
    )


def _in_turns(*, one_process: bool) -> tuple[dict[str, float], dict[str, float]]:
    """Return p99 by disturbance [ms], and what the viewers received."""
    with served_simulation(one_process=one_process) as (address, ticks, program):
        rates: dict[str, float] = {}
        disturbances: dict[str, Disturbance] = {
            "nothing": nullcontext,
            f"{VIEWERS} viewers": partial(_viewers, address, VIEWERS, rates),
            f"{CLASS} viewers": partial(_viewers, address, CLASS, {}),
            "a thread that spins": partial(in_a_thread, lambda: None),
            "a report by matplotlib": partial(in_a_thread, _draw_report),
            "a map that is drawn": partial(_map_drawn, program),
            "a slow pattern": partial(in_a_thread, lambda: PATTERN[0].match(PATTERN[1])),
        }
        times: dict[str, list[float]] = {name: [] for name in disturbances}
        for _ in range(TURNS):
            for name, disturbance in disturbances.items():
                times[name].append(_p99_ms(disturbance, ticks))
    return {name: float(np.median(each)) for name, each in times.items()}, rates


def _p99_ms(disturbance: Disturbance, ticks: Ticks) -> float:
    with disturbance():
        return ticks.percentile_ms(99, SECONDS)


@contextmanager
def _viewers(address: str, count: int, rates: dict[str, float]) -> Iterator[None]:
    """Let viewers watch, and note the rates of the slowest."""
    module = "benchmarks.viewers", address, str(count), str(SECONDS)
    command = [sys.executable, "-m", *module]
    with subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, text=True) as viewers:
        assert viewers.stdout is not None
        viewers.stdout.readline()  # wait until all are connected
        yield
        rates |= json.loads(viewers.stdout.readline())


def _draw_report() -> None:
    figure = Figure()
    FigureCanvasSVG(figure)
    axes = figure.subplots(2, 2)
    for each in axes.flat:
        each.plot(np.cumsum(np.random.default_rng(1).normal(size=(2000, 3)), axis=0))
    figure.savefig(BytesIO(), format="svg")


@contextmanager
def _map_drawn(program: Program) -> Iterator[None]:
    drawer = MapDrawer(program)
    drawer.begin(discard=True)
    try:
        yield
    finally:
        drawer.close()
