"""Benchmark of how late the control loop is beside crowds of slow clients, and without."""

from __future__ import annotations

import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager

import numpy as np

from app.settings.config import ROOT
from benchmarks.crowd_clients import CROWDS
from benchmarks.result import Result
from benchmarks.served_simulation import Ticks, served_simulation

TURNS = 5
SECONDS = 5.0
SETTLE_S = 1.0

ALL = "all at once"


def measure() -> Result:
    """Measure the 99th percentile of a tick's delay, with and without each crowd in turns.

    The median of the turns counts, as other programs disturb some of them. The crowds run on this
    machine, too.
    """
    with served_simulation() as (address, ticks, _):
        kinds = {**{kind: (kind,) for kind in CROWDS}, ALL: tuple(CROWDS)}
        times = {name: _measure_in_turns(address, crowds, ticks) for name, crowds in kinds.items()}
    more = {
        f"{name}, {case} [ms]": value
        for name, cases in times.items()
        for case, value in zip(("with", "without"), cases, strict=True)
    }
    present, alone = times[ALL]
    return Result(
        unit="ms p99 delay of a tick with all crowds",
        brickpose=present,
        peer={"without": alone},
        more=more,
    )


def _measure_in_turns(address: str, crowds: tuple[str, ...], ticks: Ticks) -> tuple[float, float]:
    """Return p99 with the crowds and without [ms]."""
    present: list[float] = []
    alone: list[float] = []
    for _ in range(TURNS):
        alone.append(_settled_ms(ticks))
        with _crowds(address, crowds):
            present.append(_settled_ms(ticks))
    return float(np.median(present)), float(np.median(alone))


def _settled_ms(ticks: Ticks) -> float:
    time.sleep(SETTLE_S)
    return ticks.percentile_ms(99, SECONDS)


@contextmanager
def _crowds(address: str, kinds: tuple[str, ...]) -> Iterator[None]:
    with ExitStack() as stack:
        for kind in kinds:
            stack.enter_context(_crowd(address, kind))
        yield


@contextmanager
def _crowd(address: str, kind: str) -> Iterator[None]:
    command = [sys.executable, "-m", "benchmarks.crowd_clients", address, kind]
    crowd = subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, text=True)
    try:
        assert crowd.stdout is not None
        if not crowd.stdout.readline():
            raise RuntimeError(f"the crowd {kind} has ended")
        yield
    finally:
        crowd.kill()
        crowd.communicate()
