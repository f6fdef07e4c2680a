"""The points of a sweep: settings, keys, shared drives, and the work of one worker."""

from __future__ import annotations

import functools
import hashlib
import itertools
import json
import math
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from app.features.lab.evaluation.drives import Drive, record
from app.features.lab.evaluation.experiment import KNOWN, follow_from_offset, in_world
from app.features.lab.evaluation.results import trajectory
from app.features.lab.evaluation.runs import (
    SHOWN,
    errors,
    follow,
    score,
    steady_error,
    time_to_converge,
)
from app.features.lab.sweep.sweep_file import Settings, SweepFile
from app.settings.conditions import apply_condition
from app.settings.config import MAPS, Config, with_settings
from app.settings.provenance import settings_of, versions
from robot.fields.field import FieldError
from robot.fields.field_loading import load_field
from robot.localization.parameters import LocalizationParameters
from robot.settings import SettingError

MOST_POINTS = 8
"""Points that follow one drive in one job: enough to justify the drive, and few enough that a
killed worker loses little."""
Row = dict[str, Any]
MEASURES = (
    "ate_rmse_m",
    "ate_aligned_rmse_m",
    "heading_rmse_rad",
    "rpe_trans_rmse_m",
    "rpe_rot_rmse_rad",
    "odometry_ate_rmse_m",
    "seconds_to_converge",
    "steady_ate_rmse_m",
    "filter_ms",
)
"""Columns of the table, besides settings, world, seed and error; None means no value. All but the
last are the same in each run; the last is a measured time."""
Measured = dict[str, Any]


@dataclass(frozen=True)
class Point:
    """One robot in one world at some settings."""

    settings: Settings = field(hash=False)
    world: str
    condition: str
    seed: int
    config: Config | None
    """None if the settings are invalid."""
    error: str = ""
    """Why the settings are invalid."""


@dataclass(frozen=True)
class SweepJob:
    """One drive, followed at several settings."""

    drive: Config
    """The configuration of the robot that drives."""
    duration: float
    """[s]"""
    offset: tuple[float, ...]
    """Error of the start pose; empty if the start is known."""
    configs: dict[str, Config] = field(hash=False)
    """The configurations that follow the drive, by the points' keys."""


def points_of(file: SweepFile, base: Config) -> list[Point]:
    """Return all points of a sweep, in the order of its table."""
    sweep = file.sweep
    seeds = range(sweep.first_seed, sweep.first_seed + sweep.seeds)
    result = []
    everywhere = list(itertools.product(sweep.worlds, sweep.conditions, seeds))
    for settings in file.points(base):
        for world, condition, seed in everywhere:
            result.append(_point(settings, world, condition, seed, base))
    return result


def _point(settings: Settings, world: str, condition: str, seed: int, base: Config) -> Point:
    try:
        config = apply_condition(in_world(replace(base, seed=seed), world), condition)
        # Swept settings override those of the world and the condition.
        return Point(settings, world, condition, seed, with_settings(config, settings))
    except SettingError as error:
        return Point(settings, world, condition, seed, None, str(error))


def key_of(config: Config, duration: float, offset: tuple[float, ...]) -> str:
    """Return a short digest of everything that a result depends on.

    These are the settings and the seed, the map, the user's own models with the files beside them,
    the program's code and the versions of the libraries that it computes with.
    """
    parts = {
        "settings": settings_of(config),
        "duration": duration,
        "offset": offset,
        "versions": versions(),
        "map": _map_digest(config.map),
        "models": [_folder_digest(model) for model in _models(config)],
    }
    return hashlib.sha256(json.dumps(parts, sort_keys=True).encode()).hexdigest()[:24]


def duration_of(file: SweepFile, config: Config) -> float:
    """Return the duration of a drive [s]."""
    return file.sweep.laps * config.figure_eight.lap


def jobs_of(
    configs: dict[str, Config],
    laps: float,
    offset: tuple[float, ...],
    most: int = MOST_POINTS,
) -> list[SweepJob]:
    """Make the jobs of configurations by key; up to ``most`` that drive alike share a drive."""
    by_drive: dict[Config, dict[str, Config]] = {}
    for key, config in configs.items():
        by_drive.setdefault(_drive_of(config), {})[key] = config
    return [
        SweepJob(drive, laps * drive.figure_eight.lap, offset, dict(some))
        for drive, alike in by_drive.items()
        for some in _batches(alike.items(), most)
    ]


def _drive_of(config: Config) -> Config:
    """Return what decides how the robot drives and what it sees, with default localization."""
    return replace(
        config,
        localization=LocalizationParameters(),
        sensor_model="",
        motion_model="",
        models="",
    )


def points_per_job(points: int, workers: int) -> int:
    """Return how many points share a drive: few enough that all workers have something to do."""
    return min(MOST_POINTS, max(1, math.ceil(points / (2 * workers))))


def _batches(items: Iterable[tuple[str, Config]], most: int) -> list[list[tuple[str, Config]]]:
    left = list(items)
    return [left[first : first + most] for first in range(0, len(left), most)]


def _models(config: Config) -> list[Path]:
    named = (config.sensor_model, config.motion_model)
    return [Path(text.rpartition(":")[0]) for text in named if text]


@functools.cache
def _map_digest(name: str) -> str:
    """Return a digest of a map's image, edges, extent and start, whatever files it comes from."""
    try:
        field = load_field(name, MAPS)
    except FieldError as error:
        return str(error)
    digest = hashlib.sha256(repr((field.start, field.extent)).encode())
    digest.update(field.floor.image.tobytes())
    digest.update(field.edges.tobytes())
    return digest.hexdigest()


def _folder_digest(model: Path) -> str:
    """Return a digest of a model's file and of the files beside it, which it may import."""
    digest = hashlib.sha256()
    for path in sorted(model.parent.glob("*.py")):
        digest.update(path.name.encode() + b"\0" + path.read_bytes())
    return digest.hexdigest()


def follow_all(job: SweepJob) -> dict[str, Measured]:
    """Return the measures of each point by its key; a point that failed has an ``error``."""
    try:
        drive = record(job.drive, job.duration)
    except Exception as error:
        return dict.fromkeys(job.configs, _failed(error))
    return {key: _measured(drive, config, job.offset) for key, config in job.configs.items()}


def _measured(drive: Drive, config: Config, offset: tuple[float, ...]) -> Measured:
    try:
        if offset:
            run = follow_from_offset(drive, config, offset)
        else:
            run = follow(drive, config, drive.ticks[0].truth, KNOWN)
    except Exception as error:
        return _failed(error)
    truth = trajectory(run, "truth")
    result, reckoned = (score(truth, trajectory(run, method)) for method in ("amcl", "odometry"))
    offsets, turns = errors(run, run.estimate)
    translation, rotation = result.relative[SHOWN]
    values = (
        result.ate,
        result.ate_aligned,
        result.heading,
        translation,
        rotation,
        reckoned.ate,
        time_to_converge(run.stamps, offsets, turns),
        steady_error(run),
        1e3 * float(np.mean(run.cpu)),
    )
    numbers = (value if math.isfinite(value) else None for value in values)
    return dict(zip(MEASURES, numbers, strict=True)) | {"error": ""}


def _failed(error: Exception) -> Measured:
    """Return the row of a point that failed; whatever the error, the sweep goes on."""
    text = str(error) or type(error).__name__
    return dict.fromkeys(MEASURES) | {"error": " ".join(text.split())}
