"""Convert fitted parameters to settings, and to a file for ``--config``.

``beam`` takes the six values of a fit unchanged: densities per metre and the probability of a miss,
as they were fitted.

``likelihood_field`` and ``likelihood_field_prob`` use z_hit exp(-d^2 / 2 sigma_hit^2) + z_rand /
range_max for a ray that returned, with z_hit + z_rand = 1. There the normal distribution is not
divided by its width, and short ranges count as false. So z_hit is the share of the returns that
come from the edge, z_hit / (z_hit + z_short + z_rand), and z_rand is the rest, as in nav2_amcl. To
get the ratio of the fitted densities, z_rand would have to be sigma_hit sqrt(2 pi) / range_max
times as large. That is about a thousandth, below the setting's smallest value, and tracks no
better. z_short, z_max and lambda_short, which these models do not use, are set as for the beam
model.
"""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from app.features.lab.model_fits.beam_fit import SensorFit
from app.features.lab.model_fits.likelihood import FitError
from app.features.lab.model_fits.motion_statistics import MotionStatistics
from app.features.lab.model_fits.sensor_statistics import SensorStatistics
from app.settings.config import Config, with_settings
from robot.driving.drive_controller import DriveSettings
from robot.localization.models.motion_models import MotionParameters
from robot.localization.models.sensor_models import SensorParameters
from robot.settings import describe

ALPHAS = ("alpha1", "alpha2", "alpha3", "alpha4")
DIGITS, NOTHING = 6, 1e-9
"""Fitted values are written with this many digits; smaller values are written as zero."""

Clipped = tuple[dict[str, float], dict[str, float]]
"""Values clipped to the ranges of the settings, and the fitted values of the clipped ones."""


def fitted_settings(
    motion: MotionStatistics, sensor: SensorStatistics | None, config: Config
) -> Clipped:
    """Return settings by path, clipped to their ranges, and the fitted values of clipped ones.

    Raises:
        FitError: the wheels differ so much that the description must be of another robot.
    """
    settings = _wheels(motion)
    alphas = dict(zip(ALPHAS, motion.fit.motion.alphas, strict=True))
    groups = {"motion": _within(alphas, describe(MotionParameters))}
    if sensor is not None:
        values, excess = fitted_sensor(sensor.usable, config.localization.sensor)
        values["likelihood_weight"] = sensor.correlation.likelihood_weight
        groups["sensor"] = values, excess
    excesses: dict[str, float] = {}
    for group, (values, excess) in groups.items():
        settings |= {f"localization.{group}.{name}": value for name, value in values.items()}
        excesses |= {f"localization.{group}.{name}": value for name, value in excess.items()}
    return {path: _rounded(value) for path, value in settings.items()}, excesses


def fitted_sensor(fit: SensorFit, defaults: SensorParameters) -> Clipped:
    """Return the fitted settings of a sensor model by name.

    If no ray was cut short, lambda_short keeps its default.
    """
    fit_values: dict[str, float] = asdict(fit.values)
    if "z_short" in fit.at_border:
        fit_values["lambda_short"] = defaults.lambda_short
    field = defaults.laser_model_type != "beam"
    if field:
        false = fit_values["z_short"] + fit_values["z_rand"]
        returned = fit_values["z_hit"] + false
        fit_values |= {"z_hit": fit_values["z_hit"] / returned, "z_rand": false / returned}
    values, excess = _within(fit_values, describe(defaults))
    if field:
        values["z_hit"] = 1 - values["z_rand"]
    return values, excess


def toml_of(settings: dict[str, Any], comments: tuple[str, ...] = ()) -> str:
    """Return settings by path as TOML text, with a table for each group.

    Raises:
        SettingError: the settings are invalid.
    """
    with_settings(Config(), settings)
    lines = [f"# {' '.join(comment.split())}" for comment in comments]
    table = ""
    for path, value in settings.items():
        group, _, name = path.rpartition(".")
        if group != table:
            lines += ["", f"[{group}]"]
            table = group
        lines.append(f"{name} = {value!r}")
    return "\n".join(lines) + "\n"


def _wheels(motion: MotionStatistics) -> dict[str, float]:
    names = ("left_wheel_radius", "right_wheel_radius", "wheel_separation")
    paths = [f"drive.{name}_multiplier" for name in names]
    wheels = dict(zip(paths, motion.multipliers, strict=True))
    limits_by_name = describe(DriveSettings)
    for path, value in wheels.items():
        limits = limits_by_name[path.rpartition(".")[2]]
        if not limits.low <= value <= limits.high:
            raise FitError(
                f"fitted, {path} is {value:.3g}, beyond {limits.low:g} to {limits.high:g}: the "
                "robot's description must be of another robot"
            )
    return wheels


def _within(fit_values: dict[str, float], limits_by_name: Any) -> Clipped:
    values = {
        name: min(max(value, limits_by_name[name].low), limits_by_name[name].high)
        for name, value in fit_values.items()
    }
    return values, {name: value for name, value in fit_values.items() if value != values[name]}


def _rounded(value: float) -> float:
    return float(f"{value:.{DIGITS}g}") if abs(value) > NOTHING else 0.0
