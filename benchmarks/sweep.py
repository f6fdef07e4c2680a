"""Benchmark of a sweep with two workers against one."""

from __future__ import annotations

import time

from app.features.lab.sweep.points import SweepJob, follow_all, jobs_of
from app.features.lab.workers import LocalWorkers
from app.settings.config import Config, with_settings
from benchmarks.result import Result

SEEDS = range(100, 108)
LAP = 16.0
"""[s]"""
WEIGHTS = (0.1, 0.2)
"""Two settings of ``likelihood_weight``, which share a drive."""


def measure() -> Result:
    """Measure points per minute, with two cores or more; workers are started before."""
    rates = {count: points_a_minute(count) for count in (1, 2, 1, 2)}
    return Result(
        unit="points/min with two workers",
        brickpose=rates[2],
        peer={"one worker": rates[1]},
        more={"two workers by one": rates[2] / rates[1]},
    )


def points_a_minute(count: int) -> float:
    """Return how many points of a sweep so many workers do in a minute."""
    crew = LocalWorkers(count)
    try:
        _do(crew, _jobs(range(count), 0.5))
        began = time.perf_counter()
        done = _do(crew, _jobs(SEEDS, LAP))
        return 60 * done / (time.perf_counter() - began)
    finally:
        crew.close()


def _do(crew: LocalWorkers, jobs: list[SweepJob]) -> int:
    """Do jobs and return the number of points."""
    done = 0
    for _, outcome in crew.each(follow_all, jobs):
        if isinstance(outcome, Exception):
            raise outcome
        done += sum(not measured["error"] for measured in outcome.values())
    return done


def _jobs(seeds: range, seconds: float) -> list[SweepJob]:
    configs = {
        f"{seed} {weight}": with_settings(
            Config(robot="sim", seed=seed), {"localization.sensor.likelihood_weight": weight}
        )
        for seed in seeds
        for weight in WEIGHTS
    }
    return jobs_of(configs, seconds / Config().figure_eight.lap, ())
