"""Settings of recordings."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from app.settings.user_data import data_folder
from robot.settings import check_settings, setting

EVERY_TICK = frozenset({"joint_states", "cmd_vel"})
"""Topics that are recorded at every tick: the robot's answers and commands. A replay needs all."""


@dataclass(frozen=True)
class RecordingSettings:
    """Where recordings go, and how much is in them."""

    record: bool = setting(False, "Record from the start (--record DIR)")
    folder: str = setting("", "Where recordings are made; else in the user's data folder")
    picture_rate: float = setting(
        15.0, "Pictures at most so often; 0 is every one", unit="Hz", low=0, high=1000
    )
    cloud_rate: float = setting(
        2.0, "Clouds of particles at most so often", unit="Hz", low=0.1, high=100
    )
    publish_rate: float = setting(
        20.0, "odom, tf and truth at most so often", unit="Hz", low=0.1, high=1000
    )

    def __post_init__(self) -> None:
        check_settings(self)

    def period(self, topic: str, rate: str | None) -> float:
        """Return the least time between two messages of a topic [s]; 0: record every message.

        Args:
            topic: its name, without slash and namespace.
            rate: the name of the setting that limits its rate; None: no limit.
        """
        if rate is None or topic in EVERY_TICK:
            return 0.0
        frequency = float(getattr(self, rate))
        return 1.0 / frequency if frequency else 0.0

    def path(self) -> Path:
        """Return the folder for new recordings."""
        return data_folder(self.folder, "recordings")
