"""The worlds in which the experiment is made: a kind of robot, and a condition."""

from __future__ import annotations

from dataclasses import replace

from app.settings.conditions import in_condition
from app.settings.config import Config
from robot.settings import SettingError

WORLDS = {
    "sim": ("sim", "default"),
    "as-real": ("sim", "as-real"),
    "hand-built": ("sim", "hand-built"),
    "kinematic": ("kinematic", "default"),
}
"""By name: which robot (``kinematic`` has perfect wheels), in which condition."""


def require_world(name: str) -> None:
    """Refuse a name that is none.

    Raises:
        SettingError: lists those that are valid.
    """
    if name not in WORLDS:
        raise SettingError(f"no world {name!r}; valid are {', '.join(WORLDS)}")


def in_world(config: Config, name: str) -> Config:
    """What a configuration becomes in a world.

    Raises:
        SettingError: there is no such world; lists those that are valid.
    """
    require_world(name)
    robot, condition = WORLDS[name]
    return in_condition(replace(config, robot=robot), condition)
