"""Robots' profiles, what calibrations have measured: where they are."""

from __future__ import annotations

from pathlib import Path

from app.settings.groups import data_folder

NONE = "none"
"""Setting that leaves a robot as it is described."""


def own_profile(robot: str) -> Path:
    """Return the file of a real robot's profile, by the robot's name."""
    return data_folder("", "profiles") / f"{robot}.toml"
