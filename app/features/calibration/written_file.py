"""Which file a running robot's calibration is written to."""

from __future__ import annotations

from pathlib import Path

from app.engine.robots import own_file, profile_file
from app.settings.config import Config


def written_file(config: Config) -> Path | None:
    """Return it; None if the robot is simulated: its calibration ends with the program."""
    own = own_file(config)
    return own and (profile_file(config) or own)
