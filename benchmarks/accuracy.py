"""Benchmark of the filters: tracking error, global localization, kidnapping and calibration.

Simulated robots with all imperfections drive the figure-eight. Each drive is recorded once, and
every filter runs on the same drives. Parameters were chosen on seeds from 100 on.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from functools import partial
from multiprocessing import get_context
from typing import TypeVar

import numpy as np

from app.features.lab.evaluation.drives import Drive, Kidnap, random_pose_on_eight, record
from app.features.lab.evaluation.experiment import KNOWN
from app.features.lab.evaluation.integrity.oracle import field_decides
from app.features.lab.trajectories.metrics import rms
from app.settings.config import Config
from benchmarks.result import Result
from benchmarks.trials import (
    PictureResult,
    WeightCalibration,
    is_right,
    right_for_good,
    setup_of,
    try_filter,
    wrong_first_claim,
)
from robot.geometry import Pose2
from robot.localization.filter import Setup
from robot.localization.parameters import FilterParameters, LocalizationParameters
from sim.floor_camera import CameraSettings
from sim.simulated import SimSettings

SEEDS = range(12)
GLOBAL_SEEDS = range(24)
KIDNAP_SEEDS = range(16)
MARKED = ("stub", "stubs", "tee")
LAPS = 31.8
"""Two laps of the figure-eight [s]."""
LAP = 16.0
CARRIED_AT, CARRIED_FOR = 10.0, 5.0
"""When the robot is carried off, and the time that it has to find its place again [s]."""
SETTLED = 1.0
"""Time after the start that does not count [s]."""
BORDERS = (0.02, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.8, 0.95, 1.001)

T = TypeVar("T")
S = TypeVar("S")


def with_filter(**changes: object) -> LocalizationParameters:
    """Return the defaults with some changed parameters of the filter."""
    return LocalizationParameters(filter=replace(FilterParameters(), **changes))  # type: ignore[arg-type]


TRACKERS = {
    "hypotheses": with_filter(),
    "particles, not refined": with_filter(filter="particles", refine=False),
    "particles": with_filter(filter="particles"),
    "Kalman": with_filter(filter="kalman", refine=False),
    "grid": with_filter(filter="grid", refine=False),
}
FINDERS = {
    "hypotheses": with_filter(),
    "particles, uniform start": with_filter(filter="particles", max_particles=10_000),
}
FINDERS_AGAIN = {
    "hypotheses": with_filter(),
    "augmented MCL": with_filter(
        filter="particles", recovery_alpha_slow=0.01, recovery_alpha_fast=0.2
    ),
}


def each(work: Callable[[S], T], jobs: Iterable[S]) -> list[T]:
    """Do jobs in parallel, with one process for each core."""
    with ProcessPoolExecutor(os.cpu_count(), mp_context=get_context("spawn")) as pool:
        return list(pool.map(work, jobs))


@dataclass(frozen=True, slots=True)
class Tracked:
    """Errors over one drive: root mean square [m] and [rad], and of dead reckoning [m]."""

    xy: float
    theta: float
    odometry: float


def track(clutter: str, seed: int) -> dict[str, Tracked]:
    """Track one robot on the square for two laps, with each filter."""
    config = Config(robot="sim", seed=seed, sim=SimSettings(camera=CameraSettings(clutter=clutter)))
    drive = record(config, LAPS)
    start = drive.ticks[0].truth
    reckoned = [start @ drive.ticks[0].odometry.inverse() @ tick.odometry for tick in drive.ticks]
    odometry_errors = [
        a.distance_to(tick.truth) for a, tick in zip(reckoned, drive.ticks, strict=True)
    ]
    errors = {}
    for name, parameters in TRACKERS.items():
        shown = try_filter(drive, parameters, seed, start, KNOWN)
        settled = [picture for picture in shown if picture.stamp > SETTLED]
        errors[name] = Tracked(
            rms([picture.error for picture in settled]),
            rms([picture.turn_error for picture in settled]),
            rms(odometry_errors),
        )
    return errors


@dataclass(frozen=True, slots=True)
class SearchOutcome:
    """Result of one filter on a drive that begins, or continues, at an unknown place."""

    right: bool
    """Whether it is right at the end."""
    seconds: float
    """Time until it stays right to the end [s]; inf if it never does."""
    wrong_claim: bool
    """Whether its first claim to be certain was wrong."""
    images: int
    """How many of the four poses that look alike on the square are among the hypotheses."""
    even: bool
    """Whether the weights of these four are within a factor of two."""
    shown: list[PictureResult]


Runs = list[tuple[float, dict[str, SearchOutcome]]]
"""For each robot the time until the field decides [s], and the result of each filter."""


def lap(map_name: str, seed: int) -> Drive:
    """Record one lap from a random pose."""
    rng = np.random.default_rng([seed, 7])
    elapsed = float(rng.uniform(0, LAP))
    start = random_pose_on_eight(rng, elapsed)
    return record(Config(robot="sim", seed=seed, map=map_name), LAP, start=start, elapsed=elapsed)


def find_with(change: Callable[[Setup], Setup], map_and_seed: tuple[str, int]) -> SearchOutcome:
    """Scatter, and drive one lap with the default filter and a changed setup."""
    map_name, seed = map_and_seed
    drive, parameters = lap(map_name, seed), LocalizationParameters()
    setup = change(setup_of(drive.field, parameters))
    return judged(try_filter(drive, parameters, seed, setup=setup), 0.0)


def find(map_and_seed: tuple[str, int]) -> tuple[float, dict[str, SearchOutcome]]:
    """Scatter, and drive one lap; return when the field decides [s], and each filter's result."""
    map_name, seed = map_and_seed
    drive = lap(map_name, seed)
    tried = {name: try_filter(drive, p, seed) for name, p in FINDERS.items()}
    return field_decides(drive, 0.0), {name: judged(shown, 0.0) for name, shown in tried.items()}


def find_again(map_and_seed: tuple[str, int]) -> tuple[float, dict[str, SearchOutcome]]:
    """Return the same for a robot that knew its place and was carried off unseen."""
    map_name, seed = map_and_seed
    rng = np.random.default_rng([seed, 7])
    elapsed = float(rng.uniform(0, LAP))
    start, elsewhere = (
        random_pose_on_eight(rng, elapsed),
        random_pose_on_eight(rng, elapsed + CARRIED_AT),
    )
    drive = record(
        Config(robot="sim", seed=seed, map=map_name),
        CARRIED_AT + CARRIED_FOR,
        start=start,
        elapsed=elapsed,
        kidnap=Kidnap(CARRIED_AT, lambda _: elsewhere),
    )
    tried = {name: try_filter(drive, p, seed, start) for name, p in FINDERS_AGAIN.items()}
    after = CARRIED_AT + 0.05
    return field_decides(drive, after) - CARRIED_AT, {
        name: judged(shown, after) for name, shown in tried.items()
    }


def judged(shown: list[PictureResult], since: float) -> SearchOutcome:
    """Return the result of a filter from a stamp [s] on."""
    last = shown[-1]
    turned = [Pose2(theta=quarter * math.pi / 2) @ last.truth for quarter in range(4)]
    weights = [
        max((h.weight for h in last.hypotheses if is_right(h.pose, pose)), default=0.0)
        for pose in turned
    ]
    return SearchOutcome(
        last.right,
        right_for_good(shown, since) - since,
        wrong_first_claim([picture for picture in shown if picture.stamp >= since]),
        sum(weight > 0 for weight in weights),
        min(weights) > 0 and max(weights) <= 2 * min(weights),
        shown,
    )


def measure() -> Result:
    """Run all parts, which takes several minutes."""
    more = tracking("none") | tracking("all")
    scattered, carried = WeightCalibration(), WeightCalibration()
    more |= places(scattered) | carried_off(carried)
    for name, claims in (
        ("all", scattered + carried), ("scattered", scattered), ("carried off", carried)
    ):  # fmt: skip
        for claimed, right, count in claims.table(BORDERS):
            more[f"{name}, claimed {claimed:.2f}: found right, of {count}"] = right
    return Result("mm position error (RMSE) tracking", more["tracking: hypotheses [mm]"],
                  {"odometry alone": more["tracking: odometry alone [mm]"]}, more)  # fmt: skip


def tracking(clutter: str) -> dict[str, float]:
    """Track twelve robots on the square for two laps, with or without clutter on the floor."""
    name = "tracking" if clutter == "none" else "among clutter"
    runs = each(partial(track, clutter), SEEDS)
    more: dict[str, float] = {}
    for tracker in TRACKERS:
        more[f"{name}: {tracker} [mm]"] = 1e3 * float(np.mean([r[tracker].xy for r in runs]))
        more[f"{name}: {tracker} [deg]"] = math.degrees(np.mean([r[tracker].theta for r in runs]))
    more[f"{name}: hypotheses, worst robot [mm]"] = 1e3 * max(r["hypotheses"].xy for r in runs)
    more[f"{name}: odometry alone [mm]"] = 1e3 * float(
        np.mean([r["hypotheses"].odometry for r in runs])
    )
    return more


def places(calibration: WeightCalibration) -> dict[str, float]:
    """Start scattered on marked fields and on the plain square."""
    more: dict[str, float] = {}
    for map_name in (*MARKED, "square"):
        runs = each(find, [(map_name, seed) for seed in GLOBAL_SEEDS])
        count = len(runs)
        for name in FINDERS:
            outcomes = [run[name] for _, run in runs]
            start = f"global start, {map_name}, {name}"
            if map_name == "square":
                more[f"{start}: all four places, of {count}"] = sum(o.images == 4 for o in outcomes)
                more[f"{start}: evenly weighed, of {count}"] = sum(o.even for o in outcomes)
            else:
                more |= fared(start, outcomes, f"{count}")
            more[f"{start}: first sure claim wrong, of {count}"] = sum(
                o.wrong_claim for o in outcomes
            )
        if map_name != "square":
            more |= oracle(f"global start, {map_name}", runs)
        more |= ours(f"global start, {map_name}", runs, calibration)
    return more


def carried_off(calibration: WeightCalibration) -> dict[str, float]:
    """Carry robots off, unseen, on marked fields."""
    more: dict[str, float] = {}
    for map_name in MARKED:
        runs = each(find_again, [(map_name, seed) for seed in KIDNAP_SEEDS])
        label = f"carried off, {map_name}"
        decidable = [by_filter for decided, by_filter in runs if decided < CARRIED_FOR]
        for name in FINDERS_AGAIN:
            outcomes = [run[name] for run in decidable]
            more |= fared(f"{label}, {name}", outcomes, f"{len(outcomes)} decidable")
        more |= oracle(label, runs) | ours(label, runs, calibration)
    return more


def fared(name: str, outcomes: list[SearchOutcome], total: str) -> dict[str, float]:
    """Return how many found their place, and when."""
    seconds = [outcome.seconds for outcome in outcomes]
    return {
        f"{name}: right, of {total}": sum(outcome.right for outcome in outcomes),
        f"{name}: median until right for good [s]": float(np.median(seconds)),
    }


def oracle(name: str, runs: Runs) -> dict[str, float]:
    """Return when the field decides."""
    decided = float(np.median([seconds for seconds, _ in runs]))
    return {f"{name}, oracle: median until decided [s]": decided}


def ours(name: str, runs: Runs, calibration: WeightCalibration) -> dict[str, float]:
    """Return the computing times of the default filter; add its claims to the calibration."""
    outcomes = [run["hypotheses"] for _, run in runs]
    for outcome in outcomes:
        calibration.add(outcome.shown)
    # At the first pictures a process may have to load compiled code.
    spent = [1e3 * shown.cpu for outcome in outcomes for shown in outcome.shown[10:]]
    return {
        f"{name}: mean of a frame [ms]": float(np.mean(spent)),
        f"{name}: 99.9 % of frames below [ms]": float(np.percentile(spent, 99.9)),
        f"{name}: longest frame [ms]": max(spent),
    }
