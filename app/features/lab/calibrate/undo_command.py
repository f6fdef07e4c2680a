"""``brickpose calibrate undo``: goes back to the profile before the last calibration."""

from __future__ import annotations

from pathlib import Path

from app.console import say
from app.engine.robots import robot_kind
from app.settings.config import AUTO, Config
from app.settings.profile_files import undo
from app.settings.profiles import own_profile
from robot.description.profile import load_profile


def undo_calibration(path: Path | None, robot: str | None = None) -> int:
    """Run the command; return 0.

    Raises:
        SettingError: there is no profile.
        SpecError: the profile before cannot be read.
    """
    kept = undo(path or own_profile(robot_kind(Config(robot=robot or AUTO)).description().name))
    if kept is None:
        say("the robot is as described again")
    else:
        profile = load_profile(kept)
        say(f"the profile is that of {profile.made:%Y-%m-%d %H:%M}, by {profile.source}: {kept}")
    return 0
