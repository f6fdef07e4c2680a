"""Fitted values become settings that mean the same to the sensor model, within their ranges."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from sensor_draws import draw_ranges

from app.features.lab.model_fits.beam_fit import SensorFit, SensorValues, fit_sensor
from app.features.lab.model_fits.fitted_file import fitted_sensor
from robot.localization.models.sensor_models import SensorParameters

FIELD = SensorParameters()
BEAM = SensorParameters(laser_model_type="beam")
SHARES = ("z_hit", "z_short", "z_max", "z_rand")


def fit_of(values: SensorValues) -> SensorFit:
    """A fit that found these values, all of them known."""
    pairs = draw_ranges(
        SensorValues(0.8, 0.08, 0.05, 0.07, 0.003, 5), 500, np.random.default_rng(0)
    )
    return replace(fit_sensor(pairs, 1.0), values=values, at_border=())


PLAIN = fit_of(SensorValues(0.7, 0.1, 0.1, 0.1, 0.004, 8.0))


def test_the_beam_model_takes_values_as_they_are() -> None:
    found, clipped = fitted_sensor(PLAIN, BEAM)
    for name in (*SHARES, "sigma_hit", "lambda_short"):
        assert found[name] == getattr(PLAIN.values, name)
    assert not clipped


@pytest.mark.parametrize("model", ["likelihood_field", "likelihood_field_prob"])
def test_a_likelihood_field_is_told_of_the_returns_alone(model: str) -> None:
    found, _ = fitted_sensor(PLAIN, replace(FIELD, laser_model_type=model))
    assert found["z_hit"] == pytest.approx(0.7 / 0.9)
    assert found["z_rand"] == pytest.approx(0.2 / 0.9)
    assert found["sigma_hit"] == 0.004


def test_what_is_not_fitted_stays() -> None:
    assert set(fitted_sensor(PLAIN, FIELD)[0]) == {*SHARES, "sigma_hit", "lambda_short"}
    unknown = replace(PLAIN, at_border=("z_short", "lambda_short"))
    assert fitted_sensor(unknown, BEAM)[0]["lambda_short"] == BEAM.lambda_short


def test_values_out_of_range_are_brought_into_it_and_told() -> None:
    exact = fit_of(SensorValues(0.9999, 0.0, 0.0, 0.0001, 1e-4, 8.0))
    found, clipped = fitted_sensor(exact, BEAM)
    assert (found["sigma_hit"], found["z_max"], found["z_rand"]) == (0.0005, 0.001, 0.001)
    assert clipped == {"sigma_hit": 1e-4, "z_max": 0.0, "z_rand": 0.0001}
    of_field, _ = fitted_sensor(exact, FIELD)
    assert of_field["z_hit"] + of_field["z_rand"] == 1
