"""The worlds of the experiment: each is a kind of robot in a condition."""

from __future__ import annotations

from dataclasses import replace

from app.settings.conditions import apply_condition
from app.settings.config import Config
from robot.settings import SettingError

WORLDS = {
    "sim": ("sim", "default"),
    "as-real": ("sim", "as-real"),
    "hand-built": ("sim", "hand-built"),
    "kinematic": ("kinematic", "default"),
}
"""Robot and condition by the world's name; the robot ``kinematic`` has perfect wheels."""


def require_world(name: str) -> None:
    """Refuse a name that is not a world.

    Raises:
        SettingError: there is no such world; lists the valid names.
    """
    if name not in WORLDS:
        raise SettingError(f"no world {name!r}; valid are {', '.join(WORLDS)}")


def in_world(config: Config, name: str) -> Config:
    """Return the configuration with the robot and the condition of a world.

    Raises:
        SettingError: there is no such world; lists the valid names.
    """
    require_world(name)
    robot, condition = WORLDS[name]
    return apply_condition(replace(config, robot=robot), condition)
