"""Fitted values as the settings of a sensor model.

``beam`` takes the six values as they are: densities by the metre and a chance of a miss, which is
what they were fitted as.

``likelihood_field`` and ``likelihood_field_prob`` are z_hit exp(-d^2 / 2 sigma_hit^2) + z_rand /
range_max for a ray that returned, with z_hit + z_rand = 1: the normal distribution there is not
divided by its width, and what is short is false too. So z_hit is the share of the returns that are
from the edge, z_hit / (z_hit + z_short + z_rand), and z_rand the rest, as in nav2_amcl. For the
ratio of the fitted densities z_rand would have to be sigma_hit sqrt(2 pi) / range_max times as
great, a thousandth or so, which is below the setting's least value and tracks no better. z_short,
z_max and lambda_short, which these models do not use, are set as for the beam model.

A filter is not better for a sigma_hit that is as small as a scanner's: between its particles, or
its cells, no pose fits such ranges, and it loses places that it starts a little beside. Fit with
``least_sigma`` as small as the filter can use, so that z_rand and the others suit that.
"""

from __future__ import annotations

from dataclasses import asdict, replace
from typing import Any

from app.lab.model_fits.sensor.fit import SensorFit
from robot.localization.models.sensor_parameters import SensorParameters
from robot.settings import describe


def fitted_sensor(fit: SensorFit, defaults: SensorParameters) -> SensorParameters:
    """The defaults with fitted values, brought into the settings' ranges.

    A lambda_short of which the rays say nothing stays what it is, as does everything that was not
    fitted. ``clipped_settings`` tells which had to be brought into their range.
    """
    known = describe(defaults)
    values: dict[str, Any] = {
        name: min(max(value, known[name].low), known[name].high)
        for name, value in _wanted(fit, defaults).items()
    }
    if defaults.laser_model_type != "beam":
        values["z_hit"] = 1 - values["z_rand"]
    return replace(defaults, **values)


def clipped_settings(fit: SensorFit, defaults: SensorParameters) -> dict[str, float]:
    """What was fitted for the settings that may not be that, by name."""
    known = describe(defaults)
    return {
        name: value
        for name, value in _wanted(fit, defaults).items()
        if not known[name].low <= value <= known[name].high
    }


def _wanted(fit: SensorFit, defaults: SensorParameters) -> dict[str, float]:
    """Settings as fitted, by name."""
    wanted: dict[str, float] = asdict(fit.values)
    if "z_short" in fit.at_border:
        del wanted["lambda_short"]
    if defaults.laser_model_type != "beam":
        false = wanted["z_short"] + wanted["z_rand"]
        returned = wanted["z_hit"] + false
        wanted |= {"z_hit": wanted["z_hit"] / returned, "z_rand": false / returned}
    return wanted
