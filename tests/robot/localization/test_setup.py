"""What filters are given has the figures that the parameters ask for, and each name is a filter."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from stub_drive import DEFAULTS, ENTRIES, SENSOR, STUB, near

from robot.localization.filter import Setup
from robot.localization.filter_kinds import FILTERS
from robot.localization.grid.grid_filter import GridFilter
from robot.localization.hypotheses.multi_hypothesis import MultiHypothesisFilter
from robot.localization.kalman_filter import KalmanFilter
from robot.localization.localizer import make_filter
from robot.localization.parameters import HypothesisParameters, LocalizationParameters
from robot.localization.particles.particle_filter import ParticleFilter

KINDS = {
    "hypotheses": MultiHypothesisFilter,
    "particles": ParticleFilter,
    "kalman": KalmanFilter,
    "grid": GridFilter,
}


def setup_with(parameters: LocalizationParameters) -> Setup:
    return Setup.of(STUB, ENTRIES, DEFAULTS.motion.model(), SENSOR, parameters)


def test_places_are_fitted_and_weighed_by_the_figures_that_are_set() -> None:
    parameters = replace(
        DEFAULTS,
        sensor=replace(DEFAULTS.sensor, laser_max_range=0.7),
        hypotheses=HypothesisParameters(fit_sd=0.02, fit_gate=0.3),
    )
    setup = setup_with(parameters)
    assert (setup.matcher.sd, setup.matcher.gate, setup.matcher.range_max) == (0.02, 0.3, 0.7)
    assert (setup.evidence.sd, setup.evidence.range_max) == (0.02, 0.7)
    assert setup.matcher.edge_index is setup.evidence.edge_index is STUB.edge_index
    assert setup.hypotheses is parameters.hypotheses and setup.filter is parameters.filter
    assert setup.likelihood_weight == parameters.sensor.likelihood_weight


def test_all_filters_that_can_be_asked_for_are_on_offer() -> None:
    assert set(FILTERS) == set(KINDS)


@pytest.mark.parametrize("name", FILTERS)
def test_the_filter_asked_for_is_made_at_the_start_of_the_field(name: str) -> None:
    parameters = replace(DEFAULTS, filter=replace(DEFAULTS.filter, filter=name))
    made = make_filter(setup_with(parameters), np.random.default_rng(0))
    assert type(made) is KINDS[name]
    assert near(made.hypotheses[0].pose, STUB.start, 0.02, 0.05)
