"""The paper's experiment: an open-loop figure-eight, from a known and from a wrong start pose.

Each robot drives once in each world, which is a kind of robot in a condition. What start pose the
filter is given changes nothing of the drive, so that the filter follows one recorded drive twice.
"""

from __future__ import annotations

import math
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from tqdm import tqdm

from app.features.lab.calibrate.command import calibrate_by_driving
from app.features.lab.evaluation.drives import Drive, EvaluationError, record
from app.features.lab.evaluation.runs import Run, follow
from app.features.lab.workers import Workers
from app.settings.conditions import apply_condition
from app.settings.config import MAPS, Config
from robot.calibration.adjustment import CalibrationError
from robot.calibration.calibrate import SHORTEST_S
from robot.description.profile import Profile
from robot.fields.field_loading import load_field
from robot.geometry import Pose2
from robot.settings import SettingError
from sim.engines import engine_version

WORLDS = {
    "sim": ("sim", "default"),
    "as-real": ("sim", "as-real"),
    "hand-built": ("sim", "hand-built"),
    "kinematic": ("kinematic", "default"),
}
"""Robot and condition by the world's name."""
KNOWN = np.diag(np.square([0.01, 0.01, 0.03]))
"""Covariance of a known start pose [m², m², rad²]. A wrong start pose has the configuration's
``initial_sd_xy`` and ``initial_sd_theta``, like a pose from the dashboard."""
OFFSET = (-0.1, -0.1, 0.3)
"""Error of the wrong start pose in the paper, in the map's axes [m, m, rad]."""
PLACED_SD = (0.05, 0.05, math.radians(10))
"""How exactly a robot that calibrates itself was put at its start (sd) [m, m, rad]."""


def require_world(name: str) -> None:
    """Refuse a name that is not a world.

    Raises:
        SettingError: there is no such world; lists the valid names.
    """
    if name not in WORLDS:
        raise SettingError(f"no world {name!r}; valid are {', '.join(WORLDS)}")


def in_world(config: Config, name: str) -> Config:
    """Return the configuration with the robot and the condition of a world.

    Raises:
        SettingError: there is no such world; lists the valid names.
    """
    require_world(name)
    robot, condition = WORLDS[name]
    return apply_condition(replace(config, robot=robot), condition)


def engine_of_worlds(config: Config, names: Sequence[str]) -> str | None:
    """Return name and version of the physics engine that drives in some worlds; None: in none."""
    robots = {WORLDS[name][0] for name in names}
    return engine_version(config.sim.engine) if "sim" in robots else None


@dataclass(frozen=True)
class Experiment:
    """Which robots drive, where and for how long."""

    config: Config = Config()
    worlds: tuple[str, ...] = ("sim", "as-real")
    first_seed: int = 0
    seeds: int = 12
    laps: int = 2
    offset: tuple[float, float, float] = OFFSET
    calibrate: float | None = None
    """Duration of the drive by which each robot calibrates itself first [s]; None: none does."""

    def __post_init__(self) -> None:
        for name in self.worlds:
            require_world(name)
        if self.calibrate is not None and not self.calibrate >= SHORTEST_S:
            raise SettingError(
                f"--calibrate is {self.calibrate:g}; valid is {SHORTEST_S:g} s or more"
            )
        if self.calibrate is not None and self.config.profile:
            raise SettingError("a profile has no effect with --calibrate; valid is one of them")
        for name, value, low in (("seeds", self.seeds, 1), ("laps", self.laps, 1)):
            if value < low:
                raise SettingError(f"{name} is {value}; valid is {low} or more")
        if not (self.first_seed >= 0 and self.first_seed + self.seeds <= 2**32):
            raise SettingError(f"first seed is {self.first_seed}; valid is 0 to 4294967295")
        if not np.isfinite(self.offset).all():
            raise SettingError(f"the offset {self.offset} is not finite")

    @property
    def duration(self) -> float:
        """Duration of a drive [s]."""
        return self.laps * self.config.figure_eight.lap

    @property
    def all_seeds(self) -> range:
        """The seeds of all robots."""
        return range(self.first_seed, self.first_seed + self.seeds)

    def jobs(self) -> list[Job]:
        """Return all drives: for each robot, one drive in each world."""
        return [
            Job(
                replace(in_world(self.config, world), seed=seed),
                world,
                self.duration,
                self.offset,
                self.calibrate,
            )
            for seed in self.all_seeds
            for world in self.worlds
        ]


@dataclass(frozen=True)
class Job:
    """One drive, to be followed with a known and with a wrong start pose."""

    config: Config
    world: str
    duration: float
    offset: tuple[float, float, float]
    calibrate: float | None = None


@dataclass(frozen=True)
class RunPair:
    """The two runs of one drive."""

    known: Run = field(repr=False)
    """The run with a known start pose."""
    offset: Run = field(repr=False)
    """The run with a wrong start pose."""
    profile: Profile | None = None
    """What the robot has measured of itself."""
    not_calibrated: str = ""
    """Why it could not calibrate itself; empty if it could, or was not asked to."""


def drive_and_follow(job: Job) -> RunPair:
    """Do one job; equal jobs have exactly equal outcomes, but for the date of a profile."""
    if job.calibrate is None:
        return _followed(job, job.config)
    start = load_field(job.config.map, MAPS).start
    error = np.random.default_rng(job.config.seed).normal(0.0, PLACED_SD)
    given_start = Pose2(*(start.to_array() + error).tolist())
    try:
        profile = calibrate_by_driving(job.config, job.calibrate, given_start).profile
    except CalibrationError as fault:
        return replace(_followed(job, job.config), not_calibrated=str(fault))
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "profile.toml"
        path.write_text(profile.to_toml(), encoding="utf-8")
        outcome = _followed(job, replace(job.config, profile=str(path)))
    return replace(outcome, profile=profile)


def _followed(job: Job, config: Config) -> RunPair:
    drive = record(config, job.duration)
    return RunPair(
        follow(drive, config, drive.ticks[0].truth, KNOWN),
        follow_from_offset(drive, config, job.offset),
    )


def follow_from_offset(drive: Drive, config: Config, offset: Sequence[float]) -> Run:
    """Follow a drive from a pose that is wrong by an offset [m, m, rad] in the map's axes."""
    start, (dx, dy, turn) = drive.ticks[0].truth, offset
    return follow(drive, config, Pose2(start.x + dx, start.y + dy, start.theta + turn))


def run(experiment: Experiment, workers: Workers) -> dict[str, list[RunPair]]:
    """Do all drives and show the progress.

    Returns:
        Outcomes by world, in the order of the seeds.

    Raises:
        EvaluationError: a drive cannot be made or followed; names seed and world.
    """
    jobs = experiment.jobs()
    result: dict[tuple[str, int], RunPair] = {}
    done = workers.each(drive_and_follow, jobs)
    for place, outcome in tqdm(done, total=len(jobs), unit="drive", disable=None):
        job = jobs[place]
        if isinstance(outcome, Exception):
            where = f"seed {job.config.seed} in the world {job.world}"
            raise EvaluationError(f"{where}: {outcome}") from outcome
        result[job.world, job.config.seed] = outcome
    return {
        world: [result[world, seed] for seed in experiment.all_seeds] for world in experiment.worlds
    }
