"""ControlSettings: in how many processes the program runs; and the options of ``run`` for them."""

from __future__ import annotations

from argparse import ArgumentParser
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from app.settings.config import Config
from robot.settings import check_settings, setting


@dataclass(frozen=True)
class ControlSettings:
    """In how many processes the program runs."""

    one_process: bool = setting(
        False, "Drive the robot in the process that serves the page, as a debugger likes it"
    )

    def __post_init__(self) -> None:
        check_settings(self)

    @classmethod
    def of(cls, config: Config) -> ControlSettings:
        """Return them as they are set."""
        return config.group("control", cls())


def add(parser: ArgumentParser) -> None:
    """Add the option to a command that serves a robot."""
    parser.add_argument(
        "--one-process",
        action="store_true",
        help="drive the robot in the process that serves the page, as a debugger likes it",
    )


def apply(config: Config, given: Mapping[str, Any]) -> Config:
    """Return the settings with what was typed."""
    if "one_process" not in given:
        return config
    table = {**config.added.get("control", {}), "one_process": given["one_process"]}
    return replace(config, added={**config.added, "control": table})
