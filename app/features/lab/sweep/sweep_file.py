"""Read a sweep file: settings and their values, seeds and worlds."""

from __future__ import annotations

import itertools
import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from app.features.lab.evaluation.experiment import WORLDS
from app.settings.conditions import condition_names, require_condition
from app.settings.config import Config, from_table
from app.settings.provenance import settings_of
from robot.settings import SettingError, check_settings, setting
from robot.toml_file import parse_toml, read_toml_text

NOT_SWEPT = ("robot", "host", "port", "seed")
"""Settings that cannot be swept: the worlds and seeds of a sweep set robot and seed."""

Settings = dict[str, Any]


@dataclass(frozen=True)
class SweepSettings:
    """The table ``[sweep]``."""

    seeds: int = setting(4, "Robots at each point", low=1, high=10_000)
    first_seed: int = setting(0, "Seed of the first robot", low=0, high=2**31)
    laps: int = setting(1, "Laps of the figure-eight", low=1, high=1000)
    worlds: tuple[str, ...] = ("sim",)
    conditions: tuple[str, ...] = ("default",)
    """Each world is combined with each condition."""
    offset: tuple[float, ...] = ()
    """Error of the start pose [m, m, rad]; empty means a known start."""
    sample: int = setting(0, "Random points; 0 is all combinations", low=0, high=1_000_000)
    sample_seed: int = setting(0, "Seed of the random points", low=0, high=2**31)

    def __post_init__(self) -> None:
        check_settings(self)
        for world in self.worlds:
            if world not in WORLDS:
                raise SettingError(f"worlds has {world!r}; valid are {', '.join(WORLDS)}")
        if not self.worlds:
            raise SettingError(f"worlds is empty; valid are {', '.join(WORLDS)}")
        if not self.conditions:
            raise SettingError(f"conditions is empty; valid are {condition_names()}")
        for condition in self.conditions:
            require_condition(condition)
        if len(self.offset) not in (0, 3) or not np.isfinite(self.offset).all():
            raise SettingError("offset is not [m, m, rad]")


@dataclass(frozen=True)
class Interval:
    """The range of a setting's values, for random points."""

    low: float
    high: float
    log: bool = False
    """Whether values are drawn evenly in the logarithm."""

    def __post_init__(self) -> None:
        if not (np.isfinite([self.low, self.high]).all() and self.low < self.high):
            raise SettingError(f"low is {self.low:g}, high is {self.high:g}; low must be less")
        if self.log and self.low <= 0:
            raise SettingError(f"low is {self.low:g}; with log it must be above zero")

    def draw(self, rng: np.random.Generator, whole: bool) -> float | int:
        """Draw a value; it is rounded if the setting is a whole number."""
        if self.log:
            value = float(np.exp(rng.uniform(np.log(self.low), np.log(self.high))))
        else:
            value = float(rng.uniform(self.low, self.high))
        return round(value) if whole else value


@dataclass(frozen=True)
class SweepFile:
    """The content of a sweep file."""

    name: str
    sweep: SweepSettings
    values: dict[str, list[Any] | Interval] = field(default_factory=dict)
    """Values by the setting's path."""

    def points(self, base: Config) -> list[Settings]:
        """Return the settings of each point, in order: of the grid, or of a random sample."""
        if self.sweep.sample:
            rng = np.random.default_rng(self.sweep.sample_seed)
            default = settings_of(base)
            return [
                {path: _drawn(values, default[path], rng) for path, values in self.values.items()}
                for _ in range(self.sweep.sample)
            ]
        lists = [values for values in self.values.values() if isinstance(values, list)]
        return [dict(zip(self.values, item, strict=True)) for item in itertools.product(*lists)]


def load_sweep(path: Path) -> SweepFile:
    """Read a sweep file.

    Raises:
        SettingError: the file is missing or not TOML, a setting is unknown, or a value is invalid;
            names file and line, and what is valid.
    """
    if not path.is_file():
        raise SettingError(f"there is no file {path}")
    text = read_toml_text(path)
    content = parse_toml(text, str(path))
    for name in content:
        if name not in ("sweep", "settings"):
            raise _wrong(path, text, name, "is unknown; valid are sweep, settings")
    for name in ("sweep", "settings"):
        if not isinstance(content.get(name, {}), dict):
            raise _wrong(path, text, name, f"is no table; valid is [{name}]")
    try:
        sweep = from_table(SweepSettings, content.get("sweep", {}))
    except SettingError as error:
        raise _wrong(path, text, str(error).split()[0], str(error).partition(" ")[2]) from error
    values = _values(path, text, content.get("settings", {}), bool(sweep.sample))
    if not values:
        raise SettingError(
            f"{path}: no settings; valid is a table [settings] with lines such as "
            "localization.sensor.sigma_hit = [0.001, 0.003, 0.01]"
        )
    return SweepFile(path.stem, sweep, values)


def _values(
    path: Path, text: str, table: dict[str, Any], sampled: bool
) -> dict[str, list[Any] | Interval]:
    known = settings_of(Config())
    result: dict[str, list[Any] | Interval] = {}
    for name, given in _flat(table, known):
        if name not in known or name in NOT_SWEPT:
            near = [item for item in known if item.rpartition(".")[2] == name.rpartition(".")[2]]
            valid = ", ".join(near) or "those of docs/configuration.md, by their path"
            raise _wrong(path, text, name, f"is no setting that can be swept; valid are {valid}")
        try:
            result[name] = _parse_choice(given, sampled)
        except SettingError as error:
            raise _wrong(path, text, name, str(error)) from error
    return result


def _flat(table: dict[str, Any], known: Settings, above: str = "") -> list[tuple[str, Any]]:
    """Return the settings by their path; names of nested tables are joined by dots."""
    result: list[tuple[str, Any]] = []
    for name, value in table.items():
        path = f"{above}{name}"
        is_group = any(item.startswith(f"{path}.") for item in known)
        if isinstance(value, dict) and (is_group or "low" not in value):
            result += _flat(value, known, f"{path}.") or [(path, value)]
        else:
            result.append((path, value))
    return result


def _parse_choice(given: Any, sampled: bool) -> list[Any] | Interval:
    if isinstance(given, dict) and given:
        if not sampled:
            raise SettingError("is an interval; that needs sample in [sweep], or list its values")
        return from_table(Interval, given)
    if not isinstance(given, list) or not given:
        raise SettingError("needs a list of values, or { low = ..., high = ... }")
    if len({repr(value) for value in given}) < len(given):
        raise SettingError(f"has a value twice: {given}")
    for value in given:
        if not isinstance(value, (str, int, float)):
            raise SettingError(f"has the value {value!r}; valid are numbers, texts, true and false")
    return given


def _drawn(values: list[Any] | Interval, default: Any, rng: np.random.Generator) -> Any:
    if isinstance(values, Interval):
        return values.draw(rng, whole=isinstance(default, int))
    return values[int(rng.integers(len(values)))]


def _wrong(path: Path, text: str, name: str, complaint: str) -> SettingError:
    """Return an error that names the line of a setting, found by the last part of its path."""
    last = re.escape(name.rpartition(".")[2])
    as_key = re.compile(rf'(^|[.\s"\'\[]){last}["\'\]]?\s*(=|\]|\.)')
    lines = [n for n, line in enumerate(text.splitlines(), 1) if as_key.search(line)]
    where = f"{path}, line {lines[0]}" if lines else str(path)
    return SettingError(f"{where}: {name} {complaint}")
