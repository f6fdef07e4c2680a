"""The option of ``run`` that records from the start."""

from __future__ import annotations

from argparse import ArgumentParser
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from app.settings.config import Config
from robot.settings import SettingError


def add(run: ArgumentParser) -> None:
    """Add the option."""
    run.add_argument(
        "--record",
        metavar="DIR",
        help="record everything to a new folder in this one (docs/recordings.md)",
    )


def apply(config: Config, given: Mapping[str, Any]) -> Config:
    """Return the settings with what was typed.

    Raises:
        SettingError: the folder is ''.
    """
    if "record" not in given:
        return config
    if not given["record"]:
        raise SettingError("--record is ''; valid is a folder")
    return replace(config, recording=replace(config.recording, record=True, folder=given["record"]))
