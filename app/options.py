"""Options that several commands share."""

from __future__ import annotations

import argparse
import functools
from collections.abc import Iterable, Mapping
from copy import deepcopy
from dataclasses import replace
from pathlib import Path
from typing import Any

from app.feature import SettingOption
from app.settings.config import Config, as_table, load_config
from robot.settings import describe

SETTINGS = {
    option.key: option
    for option in (
        SettingOption("robot", metavar="NAME"),
        SettingOption("build_hat.serial_port", metavar="DEVICE"),
        SettingOption("camera.source", metavar="SOURCE", name="camera"),
        SettingOption("map", metavar="NAME|FILE"),
        SettingOption("host"),
        SettingOption("port"),
        SettingOption("seed", metavar="N"),
        SettingOption("profile", metavar="PROFILE.toml"),
    )
}
"""Options that set settings, by what is typed."""


def add_settings(command: argparse.ArgumentParser, *names: str) -> None:
    """Add options of ``SETTINGS``."""
    for name in names:
        add_setting(command, SETTINGS[name])


def add_setting(command: argparse.ArgumentParser, option: SettingOption) -> None:
    """Add the option of a setting.

    Raises:
        LookupError: there is no such setting, or its type is none that can be typed.
    """
    tables = option.path.split(".")
    name = tables.pop()
    own = option.settings and option.settings()
    try:
        group: Any = functools.reduce(getattr, tables[1:] if own else tables, own or Config())
        known, default = describe(group)[name], getattr(group, name)
        kind: dict[str, Any] = {"action": "store_true"}
        if default is not False:
            kind = {"type": {str: str, int: int, float: float}[type(default)]}
            kind["metavar"] = option.metavar
    except (AttributeError, KeyError, TypeError) as error:
        raise LookupError(f"no option can set {option.path}; valid is a setting's path") from error
    words = known.meaning[0].lower() + known.meaning[1:] + (known.unit and f" [{known.unit}]")
    if default is not False and default != "":
        words += f" (default: {default})"
    command.add_argument(option.flag, help=words.replace("%", "%%"), **kind)


def add_config(command: argparse.ArgumentParser) -> None:
    """Add the option for a file of settings."""
    words = "settings (docs/configuration.md); options win over them"
    command.add_argument("--config", type=Path, metavar="FILE.toml", help=words)


def config_from(parsed: argparse.Namespace) -> Config:
    """Return the configuration of the file, if one is given, overridden by the other options."""
    given = vars(parsed)
    config = config_of(given, SETTINGS)
    return given["features"].with_run_options(config, given) if "features" in given else config


def config_of(given: dict[str, Any], names: Iterable[str] = ("map", "profile")) -> Config:
    """Return the configuration of the file, if one is given, overridden by named options."""
    config = config_file(given)
    for name in names:
        config = with_setting(config, SETTINGS[name], given)
    return config


def with_setting(config: Config, option: SettingOption, given: Mapping[str, Any]) -> Config:
    """Return the configuration with a setting, if its option was typed.

    Raises:
        SettingError: the value is invalid.
    """
    if option.key in given and option.settings is None:
        config = _replaced(config, option.path, given[option.key])
    elif option.key in given and option.settings is not None:
        added = as_table({option.path: given[option.key]}, deepcopy(dict(config.added)))
        config = replace(config, added=added)
        config.group(option.path.partition(".")[0], option.settings())
    return config


def _replaced(group: Any, path: str, value: Any) -> Any:
    name, _, rest = path.partition(".")
    return replace(group, **{name: _replaced(getattr(group, name), rest, value) if rest else value})


def config_file(given: Mapping[str, Any]) -> Config:
    """Return the configuration of the file, if one is given; else the defaults."""
    if given.get("config") is None:
        return Config()
    features = given.get("features")
    if features is None:
        return load_config(given["config"])
    return load_config(given["config"], features.settings, features.left_out)
