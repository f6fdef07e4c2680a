"""The points of a sweep: what each sets, its key, and the drives that points share."""

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

from app.lab.evaluation.worlds import in_world
from app.lab.sweep.sweep_file import Settings, SweepFile
from app.settings.conditions import in_condition
from app.settings.config import MAPS, Config, with_settings
from app.settings.provenance import settings_of, versions
from robot.fields.field import FieldError
from robot.fields.field_loading import load_field
from robot.localization.parameters import LocalizationParameters
from robot.settings import SettingError

AT_ONCE = 8
"""Points that follow one drive in one job: enough to make the drive worth it, and few enough that
a killed worker loses little."""


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
    """Why they are."""


@dataclass(frozen=True)
class SweepJob:
    """One drive, followed at several settings."""

    drive: Config
    """As the robot needs it."""
    duration: float
    """[s]"""
    offset: tuple[float, ...]
    """Of the told pose, or none."""
    configs: dict[str, Config] = field(hash=False)
    """By the points' keys."""


def points_of(file: SweepFile, base: Config) -> list[Point]:
    """All points of a sweep, in the order of its table."""
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
        config = in_condition(in_world(replace(base, seed=seed), world), condition)
        # What is swept wins over what world and condition set.
        return Point(settings, world, condition, seed, with_settings(config, settings))
    except SettingError as error:
        return Point(settings, world, condition, seed, None, str(error))


def key_of(config: Config, duration: float, offset: tuple[float, ...]) -> str:
    """What a result depends on, as a short text.

    Settings and seed, map, models of the user's own with the files beside them, the program's code
    and the versions of what it computes with.
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
    """Of a drive [s]."""
    return file.sweep.laps * config.figure_eight.lap


def jobs_of(
    configs: dict[str, Config],
    laps: float,
    offset: tuple[float, ...],
    most: int = AT_ONCE,
) -> list[SweepJob]:
    """Work for configurations by key: those that drive alike share a drive, so many at most."""
    by_drive: dict[Config, dict[str, Config]] = {}
    for key, config in configs.items():
        by_drive.setdefault(_drive_of(config), {})[key] = config
    return [
        SweepJob(drive, laps * drive.figure_eight.lap, offset, dict(some))
        for drive, alike in by_drive.items()
        for some in _batches(alike.items(), most)
    ]


def _drive_of(config: Config) -> Config:
    """What decides how the robot drives and what it sees, without what follows it."""
    return replace(
        config,
        localization=LocalizationParameters(),
        sensor_model="",
        motion_model="",
        models="",
    )


def at_once(points: int, workers: int) -> int:
    """How many points share a drive: the fewer, the more workers have something to do."""
    return min(AT_ONCE, max(1, math.ceil(points / (2 * workers))))


def _batches(items: Iterable[tuple[str, Config]], most: int) -> list[list[tuple[str, Config]]]:
    left = list(items)
    return [left[first : first + most] for first in range(0, len(left), most)]


def _models(config: Config) -> list[Path]:
    named = (config.sensor_model, config.motion_model)
    return [Path(text.rpartition(":")[0]) for text in named if text]


@functools.cache
def _map_digest(name: str) -> str:
    """Of what a map shows and where its edges are, from whatever files it was read."""
    try:
        field = load_field(name, MAPS)
    except FieldError as error:
        return str(error)
    digest = hashlib.sha256(repr((field.start, field.extent)).encode())
    digest.update(field.floor.image.tobytes())
    digest.update(field.edges.tobytes())
    return digest.hexdigest()


def _folder_digest(model: Path) -> str:
    """Of a model's file and of those beside it, which it may import."""
    digest = hashlib.sha256()
    for path in sorted(model.parent.glob("*.py")):
        digest.update(path.name.encode() + b"\0" + path.read_bytes())
    return digest.hexdigest()


Row = dict[str, Any]
