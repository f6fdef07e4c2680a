"""SearchBeside: searches the field beside a filter that makes no search, so that claims rest on it.

A cloud, a Gaussian or a grid that has left the robot's place stays where it is, and on a floor that
looks alike its scans may fit there. Nothing in it tells that; a search of the whole field does.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from robot.geometry import Pose2
from robot.localization.estimate import ONLY_PLACE, Standing
from robot.localization.filter import Filter, Setup
from robot.localization.filter_kinds import OURS
from robot.localization.models.sensor_models import SensorParameters, sensor_model
from robot.localization.parameters import FilterParameters, HypothesisParameters


class SearchBeside:
    """A filter of hypotheses that goes along with one that makes no search."""

    def __init__(self, setup: Setup, searching: Filter | None = None) -> None:
        """Go on with a filter of hypotheses; without one, with a new one at the field's start."""
        own = usual(setup)
        # It draws numbers of its own.
        self.filter = searching or OURS["hypotheses"].make(own, np.random.default_rng(0))
        self.filter.use(own)
        self._alike = own.hypotheses.alike

    def use(self, setup: Setup) -> None:
        """Take the models and parameters of a setup, as far as they are not the other filter's."""
        self.filter.use(usual(setup))

    def standing_at(self, pose: Pose2) -> Standing:
        """Return how far a pose is confirmed that another filter holds for the robot's."""
        standing, places = self.filter.standing, self.filter.hypotheses
        only = bool(places) and places[0].weight > ONLY_PLACE
        same = only and self._alike(places[0].pose, pose)
        return standing if same or standing is Standing.LOST else Standing.UNCONFIRMED


def usual(setup: Setup) -> Setup:
    """Return a setup with the usual sensor model and parameters, on the same field and ranges.

    What another filter does not use (its parameters are idle), and a user's own sensor model, must
    not decide whether its place is confirmed. How far a step may err is the same for both.
    """
    given, low, high = setup.parameters, *setup.reach
    far, cell = given.sensor.laser_likelihood_max_dist, given.sensor.field_resolution
    start, rays = given.filter, given.hypotheses
    parameters = replace(
        given,
        sensor=replace(
            SensorParameters(), laser_min_range=low, laser_max_range=high,
            laser_likelihood_max_dist=far, field_resolution=cell,
        ),
        filter=replace(
            FilterParameters(), initial_sd_xy=start.initial_sd_xy,
            initial_sd_theta=start.initial_sd_theta,
        ),
        hypotheses=HypothesisParameters(fit_sd=rays.fit_sd, fit_gate=rays.fit_gate),
    )  # fmt: skip
    model = sensor_model(parameters.sensor, setup.entries, setup.field.edges)
    return Setup.of(setup.field, setup.entries, setup.motion, model, parameters)
