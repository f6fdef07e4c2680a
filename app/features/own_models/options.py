"""The options for the user's own sensor and motion models."""

from __future__ import annotations

from argparse import ArgumentParser
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from app.settings.config import Config

OPTIONS = ("sensor_model", "motion_model", "models")
"""Options that set the top-level settings of the same names."""


def add(command: ArgumentParser) -> None:
    """Add the options."""
    for kind in ("sensor", "motion"):
        command.add_argument(
            f"--{kind}-model",
            metavar="FILE.py:CLASS",
            help=f"a {kind} model of your own, read again when it is saved (docs/own_models.md)",
        )
    command.add_argument(
        "--models", metavar="DIR", help="a folder of models of your own, which the page offers"
    )


def apply(config: Config, given: Mapping[str, Any]) -> Config:
    """Return the settings with what was typed."""
    return replace(config, **{name: given[name] for name in OPTIONS if name in given})
