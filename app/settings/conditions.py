"""Named conditions: what is worse than usual in a simulated robot, its camera or its floor.

Each condition is a table of settings by their path (docs/configuration.md). A condition only makes
a setting worse: if the configuration's value is already worse, that value stays.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

from app.settings.config import Config, by_path, with_settings
from robot.settings import SettingError

Preset = Mapping[str, Any]


def _late(seconds: float) -> Preset:
    # The picture is also delivered later: its stamp must not lie in the future.
    return {"sim.camera.stamp_error": seconds, "sim.camera.delay": 0.005 + seconds}


_AS_REAL: Preset = {
    "sim.imperfections.slip_sd": 0.04,
    "sim.imperfections.camera_angle_sd": 0.3,
    "sim.imperfections.camera_position_sd": 0.001,
    "sim.camera.uneven_light": 0.5,
    "sim.camera.clutter": "shadow",
    **_late(0.020),
}

CONDITIONS: Mapping[str, Preset] = MappingProxyType(
    {
        "default": {},
        "noisy": {"sim.camera.noise": 40.0},
        "dark": {"sim.camera.light": 0.3},
        "uneven": {"sim.camera.uneven_light": 0.9},
        "cluttered": {"sim.camera.clutter": "all", "sim.camera.glare": 150.0},
        "fast": {"figure_eight.speed": 0.3, "sim.camera.exposure": 0.030},
        "askew": {"sim.imperfections.camera_angle_sd": 0.5},
        "late": _late(0.030),
        "worn": {"sim.imperfections.wheel_radius_sd": 0.05},
        "slippery": {"sim.imperfections.slip_sd": 0.2},
        "stretched": {"sim.camera.floor_scale": 1.02},
        "sparse": {"sim.camera.frame_rate": 3.0},
        "gaps": {
            "sim.camera.lost_share": 0.9,
            "sim.camera.lost_burst": 0.33,
            "sim.camera.gap": 4.0,
        },
        "all-at-once": {
            "sim.imperfections.camera_angle_sd": 0.5,
            "sim.imperfections.slip_sd": 0.1,
            "sim.imperfections.wheel_radius_sd": 0.03,
            "sim.camera.noise": 15.0,
            "sim.camera.clutter": "all",
            **_late(0.030),
        },
        **{f"bumped-{axis}": {"sim.imperfections.bump": axis} for axis in ("roll", "pitch", "yaw")},
        "as-real": _AS_REAL,
        "hand-built": {
            **_AS_REAL,
            "sim.imperfections.camera_angle_sd": 1.5,
            "sim.imperfections.camera_position_sd": 0.005,
            "sim.imperfections.focal_length_sd": 0.02,
            "sim.imperfections.wheel_radius_sd": 0.03,
            "sim.imperfections.track_sd": 0.05,
            **_late(0.040),
        },
    }
)
"""The settings of each condition. ``as-real`` is a robot that nobody has calibrated; ``hand-built``
is a robot assembled by hand at the first try."""

LESS_IS_WORSE = ("sim.camera.light", "sim.camera.frame_rate")


def condition_names() -> str:
    """Return all condition names, as messages and help list them."""
    return ", ".join(CONDITIONS)


def require_condition(name: str) -> None:
    """Refuse an unknown condition name.

    Raises:
        SettingError: the name is unknown; lists the valid names.
    """
    if name not in CONDITIONS:
        raise SettingError(f"no condition {name!r}; valid are {condition_names()}")


def apply_condition(config: Config, name: str) -> Config:
    """Return a configuration with a condition applied.

    Raises:
        SettingError: the condition is unknown; lists the valid names.
    """
    require_condition(name)
    preset, known = CONDITIONS[name], by_path(dataclasses.asdict(config))
    return with_settings(config, {path: _worse(path, known[path], preset[path]) for path in preset})


def _worse(path: str, known: Any, preset: Any) -> Any:
    if isinstance(preset, str):
        return preset if known == "none" else known
    return min(known, preset) if path in LESS_IS_WORSE else max(known, preset)
