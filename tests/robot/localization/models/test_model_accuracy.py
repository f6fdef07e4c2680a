"""With exact scans every model for driving follows the robot within a millimetre or so."""

from __future__ import annotations

from dataclasses import replace

import pytest
from places import MAPS

from benchmarks.models import track
from robot.fields.field_loading import load_field
from robot.localization.models.motion_models import MotionParameters
from robot.localization.models.sensor_models import SensorParameters
from robot.localization.parameters import LocalizationParameters

SQUARE = load_field("square", MAPS)
LITTERED = (104, 105, 107)
CHOICES = [
    (MotionParameters(), SensorParameters(), 1.0),
    (MotionParameters(robot_model_type="omni"), SensorParameters(), 1.8),
    (MotionParameters(robot_model_type="velocity"), SensorParameters(), 1.0),
    (MotionParameters(), SensorParameters(laser_model_type="beam"), 1.0),
]


@pytest.mark.parametrize(("motion", "sensor", "most_mm"), CHOICES)
def test_over_a_lap_of_the_eight_the_error_stays_small(
    motion: MotionParameters, sensor: SensorParameters, most_mm: float
) -> None:
    """Twice what it is on average over twelve seeds, with wheels and track not as described."""
    parameters = replace(LocalizationParameters(), motion=motion, sensor=sensor)
    assert track(SQUARE, 101, parameters) < 1e-3 * most_mm


def test_skipping_rays_helps_on_a_littered_floor_when_ranges_are_believed_little() -> None:
    """With ``sigma_hit`` at 3 mm it hardly matters: far ends say nothing anyway."""
    errors = {}
    for name in ("likelihood_field", "likelihood_field_prob"):
        sensor = SensorParameters(
            laser_model_type=name, sigma_hit=0.01, do_beamskip=True, beam_skip_distance=0.015
        )
        parameters = replace(LocalizationParameters(), sensor=sensor)
        runs = [track(SQUARE, seed, parameters, litter=True) for seed in LITTERED]
        errors[name] = sum(runs) / len(runs)
    assert errors["likelihood_field_prob"] < 0.8 * errors["likelihood_field"]
