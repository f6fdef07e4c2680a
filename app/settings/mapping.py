"""Settings of maps that are drawn by driving."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from app.settings.user_data import data_folder
from robot.settings import check_settings, setting


@dataclass(frozen=True)
class MappingSettings:
    """Where maps go that the page saves."""

    folder: str = setting("", "Where maps are saved; else in the user's data folder")

    def __post_init__(self) -> None:
        check_settings(self)

    def path(self) -> Path:
        """Return the folder for new maps."""
        return data_folder(self.folder, "maps")
