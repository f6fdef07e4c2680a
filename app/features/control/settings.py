"""ControlSettings: in how many processes the program runs."""

from __future__ import annotations

from dataclasses import dataclass

from app.settings.config import Config
from robot.settings import check_settings, setting


@dataclass(frozen=True)
class ControlSettings:
    """In how many processes the program runs."""

    one_process: bool = setting(
        False, "Drive the robot in the process that serves the page, as a debugger likes it"
    )

    def __post_init__(self) -> None:
        check_settings(self)

    @classmethod
    def of(cls, config: Config) -> ControlSettings:
        """Return them as they are set."""
        return config.group("control", cls())
