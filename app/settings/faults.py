"""Faults of a simulated robot and its camera that can be changed while it drives."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from app.settings.conditions import CONDITIONS
from app.settings.config import with_settings
from robot.settings import SettingError
from sim.simulated import SimSettings

ROBOT = (
    "slip_sd", "wheel_radius_sd", "track_sd", "camera_angle_sd", "camera_position_sd",
    "focal_length_sd",
)  # fmt: skip
"""Of wheels and mounting."""
CAMERA = (
    "noise", "light", "uneven_light", "glare", "clutter", "floor_scale", "exposure", "blur",
    "stamp_error", "frame_rate", "lost_share", "lost_burst", "gap",
)  # fmt: skip
"""Of pictures."""
TABLES: Mapping[str, str] = {
    **dict.fromkeys(ROBOT, "imperfections"),
    **dict.fromkeys(CAMERA, "camera"),
}
"""The table of ``SimSettings`` that each fault is in."""


def fault_values(settings: SimSettings) -> dict[str, float | str]:
    """Return the value of each fault."""
    return {name: getattr(getattr(settings, table), name) for name, table in TABLES.items()}


def changed_faults(settings: SimSettings, before: SimSettings) -> dict[str, float | str]:
    """Return the faults that differ from those of other settings."""
    earlier = fault_values(before)
    return {name: value for name, value in fault_values(settings).items() if value != earlier[name]}


def with_faults(settings: SimSettings, values: Mapping[str, float | str]) -> SimSettings:
    """Return settings with other faults.

    A picture that is stamped later is delivered later, too: no stamp may lie in the future.

    Raises:
        SettingError: a name is unknown or a value out of range; the message says what is valid.
    """
    unknown = [name for name in values if name not in TABLES]
    if unknown:
        raise SettingError(f"there is no fault {unknown[0]}; valid are {', '.join(TABLES)}")
    result = with_settings(settings, {f"{TABLES[name]}.{name}": values[name] for name in values})
    later = result.camera.stamp_error - settings.camera.stamp_error
    delay = min(max(settings.camera.delay + later, 0.0), 1.0)
    return replace(result, camera=replace(result.camera, delay=delay))


def condition_faults(name: str) -> dict[str, Any]:
    """Return the faults of a named condition."""
    preset = {path.rpartition(".")[2]: value for path, value in CONDITIONS[name].items()}
    return {fault: value for fault, value in preset.items() if fault in TABLES}
