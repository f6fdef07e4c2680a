"""The integrity experiment (robots x fields x conditions x starts), and the work of one worker."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from tqdm import tqdm

from app.engine.robots import robot_kind
from app.features.lab.evaluation.integrity.claims import STARTS, claims_csv, follow_claims
from app.features.lab.evaluation.integrity.drives import (
    TrialDrive,
    carried_drive,
    lap_drive,
    moved_drive,
)
from app.features.lab.evaluation.integrity.measures import measures
from app.features.lab.evaluation.integrity.mishaps import (
    Mishap,
    apply_any_condition,
    mishap_of,
)
from app.features.lab.evaluation.integrity.oracle import decided_stamp, decision_measures
from app.features.lab.evaluation.integrity.summary import Stanford, counted
from app.features.lab.workers import Workers
from app.settings.config import MAPS, Config
from robot.fields.field_loading import load_field
from robot.settings import SettingError
from sim.engines import engine_version

KIDNAPPED: dict[str, Callable[[Config, Mishap], TrialDrive]] = {
    "carried": carried_drive,
    "known-carried": carried_drive,
    "moved": moved_drive,
}
"""Starts that need a drive of their own."""


@dataclass(frozen=True)
class IntegrityExperiment:
    """The robots, fields, conditions and starts of the experiment."""

    config: Config = Config()
    maps: tuple[str, ...] = ("square", "stub", "town")
    conditions: tuple[str, ...] = ("default",)
    starts: tuple[str, ...] = STARTS
    first_seed: int = 0
    seeds: int = 12
    laps: int = 1

    def __post_init__(self) -> None:
        for name in self.conditions:
            apply_any_condition(self.config, name)
        for name in self.starts:
            if name not in STARTS:
                raise SettingError(f"no start {name!r}; valid are {', '.join(STARTS)}")
        for name in self.maps:
            load_field(name, MAPS)
        for name, count in (("seeds", self.seeds), ("laps", self.laps)):
            if count < 1:
                raise SettingError(f"{name} is {count}; valid is 1 or more")
        if not (self.first_seed >= 0 and self.first_seed + self.seeds <= 2**32):
            raise SettingError(f"first seed is {self.first_seed}; valid is 0 to 4294967295")
        stems = [map_stem(name) for name in self.maps]
        if len(set(stems)) < len(stems):
            raise SettingError(f"two maps have one name: {', '.join(stems)}; give each its own")

    def jobs(self) -> list[IntegrityJob]:
        """Return all drives, grouped by field, as a worker keeps the tables of the last field."""
        laps = tuple(start for start in self.starts if start not in KIDNAPPED)
        kidnapped = [
            tuple(start for start in self.starts if KIDNAPPED.get(start) is drive)
            for drive in dict.fromkeys(KIDNAPPED.values())
        ]
        groups = [group for group in (laps, *kidnapped) if group]
        return [
            IntegrityJob(self._config(name, condition, seed), condition, group, self.laps)
            for name in self.maps
            for condition in self.conditions
            for seed in range(self.first_seed, self.first_seed + self.seeds)
            for group in groups
        ]

    @property
    def engine(self) -> str | None:
        """Name and version of the physics engine that drives; None: none does."""
        if not robot_kind(self.config).has_forces:
            return None
        return engine_version(self.config.sim.engine)

    def _config(self, name: str, condition: str, seed: int) -> Config:
        robot = robot_kind(self.config).name
        return apply_any_condition(
            replace(self.config, robot=robot, map=name, seed=seed), condition
        )


@dataclass(frozen=True)
class IntegrityJob:
    """One drive, followed from several starts."""

    config: Config
    condition: str
    starts: tuple[str, ...]
    laps: int


@dataclass(frozen=True)
class IntegrityRun:
    """One robot from one start."""

    row: dict[str, Any]
    """Its row in ``results.json``."""
    csv: str
    stanford: Stanford


def do_job(job: IntegrityJob) -> list[IntegrityRun]:
    """Drive once and follow from each start; equal jobs have exactly equal outcomes."""
    make, mishap = KIDNAPPED.get(job.starts[0]), mishap_of(job.condition)
    trial = make(job.config, mishap) if make else lap_drive(job.config, job.laps, mishap)
    return [_run(job, trial, start) for start in job.starts]


def _run(job: IntegrityJob, trial: TrialDrive, start: str) -> IntegrityRun:
    claims = follow_claims(trial, job.config, start)
    decided = decided_stamp(trial, claims, job.config, start)
    about = {
        "map": map_stem(job.config.map),
        "condition": job.condition,
        "start": start,
        "seed": job.config.seed,
    }
    row = about | measures(claims) | decision_measures(claims, decided)
    return IntegrityRun(row, claims_csv(claims), counted(claims))


def map_stem(name: str) -> str:
    """Return the name of a field in results and folders."""
    return Path(name).stem


@dataclass(frozen=True)
class Failure:
    """A drive that could not be made or followed."""

    map: str
    condition: str
    seed: int
    error: str


def each_run(jobs: list[IntegrityJob], workers: Workers) -> Iterator[IntegrityRun | Failure]:
    """Do all drives and show the progress; yields robots in the order in which they finish.

    A drive that fails is yielded as a failure and the rest goes on, so that one drive does not cost
    hours of work.
    """
    done = workers.each(do_job, jobs)
    for place, outcome in tqdm(done, total=len(jobs), unit="drive", disable=None):
        job = jobs[place]
        if isinstance(outcome, Exception):
            reason = " ".join(str(outcome).split()) or type(outcome).__name__
            yield Failure(map_stem(job.config.map), job.condition, job.config.seed, reason)
        else:
            yield from outcome
