"""The points of a sweep: what each sets, its key, and the drives that points share."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from app.batch.provenance import code_version, settings_of
from app.config import Config, with_settings
from app.engine.figure_eight import FigureEight
from app.evaluation.worlds import WORLDS
from app.sweep.sweep_file import Settings, SweepFile
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
    found = []
    for settings in file.points(base):
        for world in sweep.worlds:
            for seed in seeds:
                found.append(_point(settings, world, seed, base))
    return found


def _point(settings: Settings, world: str, seed: int, base: Config) -> Point:
    try:
        config = WORLDS[world](replace(base, seed=seed))
        # What is swept wins over what the world sets.
        return Point(settings, world, seed, with_settings(config, settings))
    except SettingError as error:
        return Point(settings, world, seed, None, str(error))


def key_of(config: Config, duration: float, offset: tuple[float, ...]) -> str:
    """What a result depends on, as a short text: settings, seed, files, and the code itself."""
    files = [config.map, *(text.rpartition(":")[0] for text in _models(config))]
    parts = {
        "settings": settings_of(config),
        "duration": duration,
        "offset": offset,
        "code": code_version(),
        "files": {name: _digest(Path(name)) for name in files if Path(name).is_file()},
    }
    return hashlib.sha256(json.dumps(parts, sort_keys=True).encode()).hexdigest()[:24]


def duration_of(file: SweepFile) -> float:
    """Of a drive [s]."""
    return file.sweep.laps * FigureEight().lap


def jobs_of(
    configs: dict[str, Config], duration: float, offset: tuple[float, ...]
) -> list[SweepJob]:
    """Work for configurations by key: those that drive alike share a drive."""
    by_drive: dict[Config, dict[str, Config]] = {}
    for key, config in configs.items():
        by_drive.setdefault(_drive_of(config), {})[key] = config
    return [
        SweepJob(drive, duration, offset, dict(some))
        for drive, alike in by_drive.items()
        for some in _batches(alike.items())
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


def _batches(items: Iterable[tuple[str, Config]]) -> list[list[tuple[str, Config]]]:
    left = list(items)
    return [left[first : first + AT_ONCE] for first in range(0, len(left), AT_ONCE)]


def _models(config: Config) -> list[str]:
    return [text for text in (config.sensor_model, config.motion_model) if text]


def _digest(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


Row = dict[str, Any]
