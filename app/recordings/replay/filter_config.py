"""Settings that a replay has otherwise than the recording."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from app.settings.config import Config, by_path, read_toml, with_settings
from robot.settings import SettingError

TABLES = ("localization", "scanner", "odometry", "drive", "start_pose")
"""What changes a replay."""


def read_filter_config(path: Path) -> dict[str, Any]:
    """Settings by their path (``localization.filter.max_particles``), of a TOML file.

    Raises:
        SettingError: it cannot be read, or has settings that change no replay.
    """
    content = read_toml(path)
    others = sorted(content.keys() - set(TABLES))
    if others:
        raise SettingError(
            f"{path}: {others[0]} changes no replay; valid are the tables {', '.join(TABLES)}"
        )
    return by_path(content)


def with_filter_config(config: Config, path: Path) -> tuple[Config, frozenset[str]]:
    """The settings with those of a file over them, and the names of the filter's among these.

    Raises:
        SettingError: one is misspelt or out of range.
    """
    given = read_filter_config(path)
    try:
        changed = with_settings(config, given)
    except SettingError as error:
        raise SettingError(f"{path}: {error}") from error
    names = (name for name in given if name.startswith("localization."))
    return changed, frozenset(name.rpartition(".")[2] for name in names)
