"""The user's folders, where each operating system keeps such.

freedesktop.org's variables come first on every system: who sets one means it.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Mapping
from pathlib import Path


def data_folder(environment: Mapping[str, str] = os.environ) -> Path:
    """Return the folder for what the user makes: recordings, maps, profiles."""
    return _folder(environment, "XDG_DATA_HOME", ".local/share", "Application Support")


def state_folder(environment: Mapping[str, str] = os.environ) -> Path:
    """Return the folder for what the program keeps from one run to the next."""
    return _folder(environment, "XDG_STATE_HOME", ".local/state", "Application Support")


def cache_folder(environment: Mapping[str, str] = os.environ) -> Path:
    """Return the folder for what can be made again.

    Raises:
        RuntimeError: this user has no home.
    """
    return _folder(environment, "XDG_CACHE_HOME", ".cache", "Caches")


def _folder(environment: Mapping[str, str], variable: str, usual: str, in_library: str) -> Path:
    chosen = Path(environment.get(variable, ""))
    if chosen.is_absolute():  # the standard says that a relative path counts as none
        return chosen / "brickpose"
    if sys.platform == "win32":
        local = environment.get("LOCALAPPDATA")
        return (Path(local) if local else Path.home() / "AppData" / "Local") / "BrickPose"
    if sys.platform == "darwin":
        return Path.home() / "Library" / in_library / "BrickPose"
    return Path.home() / usual / "brickpose"
