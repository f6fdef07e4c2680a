"""Settings of a replay that differ from those of the recording."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from app.settings.config import Config, by_path, read_toml, with_settings
from robot.settings import SettingError

TABLES = ("localization", "scanner", "odometry", "drive", "start_pose")
"""The tables of settings that affect a replay."""


def read_filter_config(path: Path) -> dict[str, Any]:
    """Read settings by their path (``localization.filter.max_particles``) from a TOML file.

    Raises:
        SettingError: the file cannot be read, or has settings that do not affect a replay.
    """
    content = read_toml(path)
    others = sorted(content.keys() - set(TABLES))
    if others:
        raise SettingError(
            f"{path}: {others[0]} changes no replay; valid are the tables {', '.join(TABLES)}"
        )
    return by_path(content)


def with_filter_config(config: Config, path: Path) -> tuple[Config, frozenset[str]]:
    """Replace settings by those of a file; return them, and the names of the filter's in the file.

    Raises:
        SettingError: a setting is misspelt or out of range.
    """
    given = read_filter_config(path)
    try:
        changed = with_settings(config, given)
    except SettingError as error:
        raise SettingError(f"{path}: {error}") from error
    names = (name for name in given if name.startswith("localization."))
    return changed, frozenset(name.rpartition(".")[2] for name in names)
