"""Names that settings had before: refused with the new one, and read in recordings."""

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
"""Settings and tables by their path of before."""


def new_name(path: str) -> str:
    """A setting's path of today, by that of before; most are the same."""
    if path in NEW_NAMES:
        return NEW_NAMES[path]
    table, dot, name = path.partition(".")
    return f"{NEW_NAMES.get(table, table)}{dot}{name}"
