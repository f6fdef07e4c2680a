"""Faults of a simulated robot and its camera that can be changed while it drives."""

from __future__ import annotations

from collections.abc import Mapping

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
