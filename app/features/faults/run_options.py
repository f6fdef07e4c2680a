"""The option of ``run`` for a robot that is worse from the start."""

from __future__ import annotations

from argparse import ArgumentParser
from collections.abc import Mapping
from typing import Any

from app.condition_option import add_condition, with_condition
from app.settings.config import Config


def add(run: ArgumentParser) -> None:
    """Add the option."""
    add_condition(run)


def apply(config: Config, given: Mapping[str, Any]) -> Config:
    """Return the settings with what was typed; raises as ``with_condition``."""
    return with_condition(config, given)
