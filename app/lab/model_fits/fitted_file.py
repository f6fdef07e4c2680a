"""Fitted parameters as a file for ``--config``."""

from __future__ import annotations

from typing import Any

from app.lab.model_fits.fit_error import FitError
from app.lab.model_fits.motion_statistics import MotionStatistics
from app.lab.model_fits.sensor.settings import clipped_settings, fitted_sensor
from app.lab.model_fits.sensor_statistics import SensorStatistics
from app.settings.config import Config, with_settings
from robot.driving.drive_controller import DriveSettings
from robot.localization.models.motion_parameters import MotionParameters
from robot.settings import describe

DIGITS, NOTHING = 6, 1e-9
"""Fitted values are written with so many digits; smaller ones are none."""

ALPHAS = ("alpha1", "alpha2", "alpha3", "alpha4")
FITTED_SENSOR = ("sigma_hit", "z_hit", "z_short", "z_max", "z_rand", "lambda_short")


def fitted_settings(
    motion: MotionStatistics | None, sensor: SensorStatistics | None, config: Config
) -> dict[str, Any]:
    """Settings by their path, brought into their range; ``clipped`` tells which had to be.

    Raises:
        FitError: wheels are so far from the description that it is of another robot.
    """
    found: dict[str, Any] = {}
    if motion is not None:
        left, right, separation = motion.multipliers
        found["drive.left_wheel_radius_multiplier"] = left
        found["drive.right_wheel_radius_multiplier"] = right
        found["drive.wheel_separation_multiplier"] = separation
        _check_wheels(found)
        known = describe(MotionParameters)
        for name, value in zip(ALPHAS, motion.fit.motion.alphas, strict=True):
            limits = known[name]
            found[f"localization.motion.{name}"] = min(max(value, limits.low), limits.high)
    if sensor is not None:
        fitted = fitted_sensor(sensor.usable, config.localization.sensor)
        for name in FITTED_SENSOR:
            found[f"localization.sensor.{name}"] = getattr(fitted, name)
        found["localization.sensor.likelihood_weight"] = sensor.correlation.weight
    return {path: _rounded(value) for path, value in found.items()}


def clipped(
    motion: MotionStatistics | None, sensor: SensorStatistics | None, config: Config
) -> dict[str, float]:
    """What was fitted for settings that may not be that, by their path."""
    found: dict[str, float] = {}
    if motion is not None:
        known = describe(MotionParameters)
        found |= {
            f"localization.motion.{name}": value
            for name, value in zip(ALPHAS, motion.fit.motion.alphas, strict=True)
            if not known[name].low <= value <= known[name].high
        }
    if sensor is not None:
        beyond = clipped_settings(sensor.usable, config.localization.sensor)
        found |= {f"localization.sensor.{name}": value for name, value in beyond.items()}
    return found


def toml_of(settings: dict[str, Any], comments: tuple[str, ...] = ()) -> str:
    """Settings by path as TOML text, a table for each group.

    Raises:
        SettingError: they would not be accepted.
    """
    with_settings(Config(), settings)
    lines = [f"# {' '.join(comment.split())}" for comment in comments]
    table = ""
    for path, value in settings.items():
        group, _, name = path.rpartition(".")
        if group != table:
            lines += ["", f"[{group}]"]
            table = group
        lines.append(f"{name} = {_shown(value)}")
    return "\n".join(lines) + "\n"


def _check_wheels(multipliers: dict[str, Any]) -> None:
    known = describe(DriveSettings)
    for path, value in multipliers.items():
        limits = known[path.rpartition(".")[2]]
        if not limits.low <= value <= limits.high:
            raise FitError(
                f"fitted, {path} is {value:.3g}, beyond {limits.low:g} to {limits.high:g}: the "
                "robot's description must be of another robot"
            )


def _rounded(value: float) -> float:
    return float(f"{value:.{DIGITS}g}") if abs(value) > NOTHING else 0.0


def _shown(value: Any) -> str:
    return str(value).lower() if isinstance(value, bool) else repr(value)
