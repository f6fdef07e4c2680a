"""The option ``--condition`` of several commands."""

from __future__ import annotations

from argparse import ArgumentParser
from collections.abc import Mapping
from typing import Any

from app.settings.conditions import apply_condition, condition_names
from app.settings.config import Config


def add_condition(command: ArgumentParser, *, many: bool = False) -> None:
    """Add the option for conditions, which make a simulation worse."""
    repeated = "; may be given more than once" if many else ""
    command.add_argument(
        "--condition",
        metavar="NAME",
        action="append" if many else "store",
        help=f"a named condition that makes a simulation worse{repeated}: {condition_names()} "
        "(default: default)",
    )


def with_condition(config: Config, given: Mapping[str, Any]) -> Config:
    """Return the settings in the condition that was typed.

    Raises:
        SettingError: there is no such condition.
    """
    return apply_condition(config, given["condition"]) if "condition" in given else config
