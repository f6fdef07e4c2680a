"""NavigationExperiment: fields x conditions x trials x seeds, and the summary of its journeys."""

from __future__ import annotations

import math
import tempfile
from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from tqdm import tqdm

from app.engine.robots import robot_kind
from app.features.lab.calibrate.command import calibrate_by_driving
from app.features.lab.evaluation.experiment import PLACED_SD
from app.features.lab.evaluation.integrity.experiment import Failure, map_stem
from app.features.lab.evaluation.navigation.trials import (
    TRIALS,
    NavigationJob,
    NavigationRun,
    Row,
    do_trial,
)
from app.features.lab.workers import Workers
from app.settings.conditions import apply_condition, require_condition
from app.settings.config import MAPS, Config
from robot.calibration.calibrate import SHORTEST_S
from robot.fields.field_loading import load_field
from robot.geometry import Pose2
from robot.settings import SettingError
from sim.engines import engine_version


@dataclass(frozen=True)
class NavigationExperiment:
    """The robots, fields, conditions and trials of the experiment."""

    config: Config = Config()
    maps: tuple[str, ...] = ("square", "tee", "town")
    conditions: tuple[str, ...] = ("default",)
    trials: tuple[str, ...] = ("goals",)
    first_seed: int = 0
    seeds: int = 12
    goals: int = 20
    """Of one robot, one after the other."""
    minutes: float = 30.0
    """That a figure-eight is driven."""
    calibrate: float | None = None
    """Duration of the drive by which each robot calibrates itself first [s]; None: none does."""

    def __post_init__(self) -> None:
        for name in self.conditions:
            require_condition(name)
        for name in self.trials:
            if name not in TRIALS:
                raise SettingError(f"no trial {name!r}; valid are {', '.join(TRIALS)}")
        for name in self.maps:
            load_field(name, MAPS)
        stems = [map_stem(name) for name in self.maps]
        if len(set(stems)) < len(stems):
            raise SettingError(f"two maps have one name: {', '.join(stems)}; give each its own")
        self._check_numbers()

    def _check_numbers(self) -> None:
        for name, count in (("seeds", self.seeds), ("goals", self.goals)):
            if count < 1:
                raise SettingError(f"{name} is {count}; valid is 1 or more")
        if not 0 < self.minutes <= 1e4:
            raise SettingError(f"minutes is {self.minutes:g}; valid is more than 0, up to 10000")
        if self.calibrate is not None and not self.calibrate >= SHORTEST_S:
            raise SettingError(
                f"--calibrate is {self.calibrate:g}; valid is {SHORTEST_S:g} s or more"
            )
        if not (self.first_seed >= 0 and self.first_seed + self.seeds <= 2**32):
            raise SettingError(f"first seed is {self.first_seed}; valid is 0 to 4294967295")

    @property
    def engine(self) -> str | None:
        """Name and version of the physics engine that drives; None: none does."""
        if not robot_kind(self.config).has_forces:
            return None
        return engine_version(self.config.sim.engine)

    def jobs(self) -> list[CalibratedJob]:
        """Return all robots, grouped by field, as a worker keeps the tables of the last field."""
        robot = robot_kind(self.config).name
        each = (
            (name, condition, trial, seed)
            for name in self.maps
            for condition in self.conditions
            for trial in self.trials
            for seed in range(self.first_seed, self.first_seed + self.seeds)
        )
        return [
            CalibratedJob(
                NavigationJob(
                    apply_condition(
                        replace(self.config, robot=robot, map=name, seed=seed), condition
                    ),
                    condition,
                    trial,
                    self.goals,
                    self.minutes,
                ),
                self.calibrate,
            )
            for name, condition, trial, seed in each
        ]


@dataclass(frozen=True)
class CalibratedJob:
    """One robot's journeys, after it has calibrated itself if that is wanted."""

    job: NavigationJob
    calibrate: float | None


def do_calibrated(wanted: CalibratedJob) -> NavigationRun:
    """Do one robot's journeys; equal jobs have equal outcomes."""
    job = wanted.job
    if wanted.calibrate is None:
        return do_trial(job)
    start = load_field(job.config.map, MAPS).start
    error = np.random.default_rng(job.config.seed).normal(0.0, PLACED_SD)
    placed = Pose2.from_array(start.to_array() + error)
    profile = calibrate_by_driving(job.config, wanted.calibrate, placed).profile
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "profile.toml"
        path.write_text(profile.to_toml(), encoding="utf-8")
        return do_trial(replace(job, config=replace(job.config, profile=str(path))))


def each_robot(
    jobs: Sequence[CalibratedJob], workers: Workers
) -> Iterator[NavigationRun | Failure]:
    """Do all of them and show the progress; yields robots in the order in which they finish.

    A robot that fails is yielded as a failure and the rest goes on.
    """
    done = workers.each(do_calibrated, jobs)
    for place, outcome in tqdm(done, total=len(jobs), unit="robot", disable=None):
        job = jobs[place].job
        about = {
            "map": map_stem(job.config.map),
            "condition": job.condition,
            "trial": job.trial,
            "seed": job.config.seed,
        }
        if isinstance(outcome, Exception):
            reason = " ".join(str(outcome).split()) or type(outcome).__name__
            yield Failure(about["map"], job.condition, job.config.seed, reason)
        else:
            yield NavigationRun([about | row for row in outcome.rows], outcome.ticks)


def summary_of(rows: Iterable[Row]) -> list[dict[str, Any]]:
    """Return a summary for each field, condition and trial, in the rows' order."""
    groups: defaultdict[tuple[str, str, str], list[Row]] = defaultdict(list)
    for row in rows:
        groups[row["map"], row["condition"], row["trial"]].append(row)
    return [_summary(*key, each) for key, each in groups.items()]


def _summary(name: str, condition: str, trial: str, rows: list[Row]) -> dict[str, Any]:
    about: dict[str, Any] = {"map": name, "condition": condition, "trial": trial}
    about["robots"] = len({row["seed"] for row in rows})
    rooms = [row["room_m"] for row in rows if row.get("room_m") is not None]
    about |= {
        "over_tape": sum(room <= 0 for room in rooms),
        "least_room_m": min(rooms, default=None),
    }
    if trial in ("figure-eight", "open-loop"):
        left = [row["seconds"] for row in rows if row["state"] == "left the field"]
        minutes = [row["rms_by_minute_m"] for row in rows]
        return about | {
            "rms_m": float(np.sqrt(np.mean([row["rms_m"] ** 2 for row in rows]))),
            "rms_worst_robot_m": max(row["rms_m"] for row in rows),
            "first_minute_m": float(np.median([each[0] for each in minutes])),
            "last_minute_m": float(np.median([each[-1] for each in minutes])),
            "worst_minute_m": max(max(each) for each in minutes),
            "left_the_field": len(left),
            "left_after_median_s": float(np.median(left)) if left else None,
        }
    tried = [row for row in rows if row["state"] != "no goal"]
    arrived = [row for row in tried if row["state"] == "arrived"]
    # A push is no fault of the drive; its time is not compared.
    ratios = [row["seconds"] / row["fastest_s"] for row in arrived if row["fastest_s"] > 0]
    others = Counter(
        f"{row['state']}: {row['reason']}" for row in tried if row["state"] != "arrived"
    )
    return about | {
        "journeys": len(tried),
        "moved": sum(row["moved"] for row in tried),
        "reached": len(arrived),
        "error_median_m": _median(row["error_m"] for row in arrived),
        "error_worst_m": max((row["error_m"] for row in arrived), default=None),
        "turn_median_deg": _degrees(_median(row["turn_rad"] for row in arrived)),
        "turn_worst_deg": _degrees(max((row["turn_rad"] for row in arrived), default=None)),
        "seconds_median": _median(row["seconds"] for row in arrived),
        "over_fastest_median": _median(ratios),
        "not_reached": dict(others.most_common()),
    }


def _median(values: Iterable[float]) -> float | None:
    listed = list(values)
    return float(np.median(listed)) if listed else None


def _degrees(angle: float | None) -> float | None:
    return None if angle is None else math.degrees(angle)
