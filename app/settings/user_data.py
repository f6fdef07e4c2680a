"""The user's data folder."""

from __future__ import annotations

import os
from pathlib import Path


def data_folder(folder: str, usual: str) -> Path:
    """Return a folder that is set, or the usual one in the user's data folder."""
    if folder:
        return Path(folder).absolute()
    data = os.environ.get("XDG_DATA_HOME", "")
    home = Path(data) if Path(data).is_absolute() else Path.home() / ".local" / "share"
    return home / "brickpose" / usual
