"""Old names of settings: refused in a configuration (the error gives the new name), but accepted
in a recording.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from robot.settings import describe
from sim.floor_camera import CameraSettings

NEW_NAMES: Mapping[str, str] = MappingProxyType(
    {
        "camera_source": "camera.source",
        "pictures": "camera",
        "physics": "sim.physics",
        "imperfections": "sim.imperfections",
        **{f"camera.{name}": f"sim.camera.{name}" for name in describe(CameraSettings)},
    }
)
"""New paths of settings and tables, by their old paths."""


def new_name(path: str) -> str:
    """Return the present path of a setting, given its old path; most are the same."""
    if path in NEW_NAMES:
        return NEW_NAMES[path]
    table, dot, name = path.partition(".")
    return f"{NEW_NAMES.get(table, table)}{dot}{name}"
