"""Where robots' profiles are: what calibrations have measured of them."""

from __future__ import annotations

import os
from pathlib import Path

from app.settings.config import Config
from robot.description.spec import RobotSpec

NONE = "none"
"""Setting that leaves a robot as it is described."""
BEFORE = ".before"
"""Ends the name of the file that keeps a profile when another one is written over it."""


def own_profile(robot: str) -> Path:
    """Return the file of a real robot's profile, by the robot's name."""
    data = os.environ.get("XDG_DATA_HOME", "")
    folder = Path(data) if Path(data).is_absolute() else Path.home() / ".local" / "share"
    return folder / "brickpose" / "profiles" / f"{robot}.toml"


def profile_file(config: Config) -> Path | None:
    """Return the profile that holds; None if the robot is as described.

    Without a setting, that is a real robot's own one. Simulated robots have none of their own: each
    seed is another robot.
    """
    if config.profile:
        return None if config.profile == NONE else Path(config.profile)
    if config.robot != "buildhat":
        return None
    path = own_profile(RobotSpec.load().name)
    return path if path.exists() else None


def written_file(config: Config) -> Path | None:
    """Return the file that a running robot's calibration is written to.

    None if the robot is simulated: its calibration ends with the program.
    """
    if config.robot != "buildhat":
        return None
    return profile_file(config) or own_profile(RobotSpec.load().name)


def before(path: Path) -> Path:
    """Return the file that keeps the profile from before."""
    return path.with_name(path.name + BEFORE)
