"""SearchBeside: searches the field beside a filter that makes no search, so that claims rest on it.

A cloud, a Gaussian or a grid that has left the robot's place stays where it is, and on a floor that
looks alike its scans may fit there. Nothing in it tells that; a search of the whole field does.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, cast

import numpy as np

from robot.geometry import Pose2
from robot.localization.estimate import ONLY_PLACE, Standing
from robot.localization.filter import Setup
from robot.localization.filter_kinds import FILTERS, OURS
from robot.localization.models.sensor_models import SensorParameters, sensor_model
from robot.localization.parameters import (
    FilterParameters,
    HypothesisParameters,
    LocalizationParameters,
)

if TYPE_CHECKING:
    from robot.localization.hypotheses.multi_hypothesis import MultiHypothesisFilter

SEARCHES = "hypotheses"
"""The filter that searches."""


class SearchBeside:
    """A filter of hypotheses that goes along with one that makes no search."""

    def __init__(self, setup: Setup) -> None:
        """Begin at the field's start; it draws numbers of its own."""
        made = OURS[SEARCHES].make(usual(setup), np.random.default_rng(0))
        self.filter = cast("MultiHypothesisFilter", made)

    @classmethod
    def of(cls, setup: Setup) -> SearchBeside | None:
        """Return what searches beside the filter of a setup; None if that filter does so itself.

        On a map without tape, as a laser's of a building, nothing searches.
        """
        searches = FILTERS[setup.filter.filter].has_hypotheses or not setup.field.tape
        return None if searches else cls(setup)

    def use(self, setup: Setup) -> None:
        """Switch to another field's models, and keep the belief."""
        self.filter.use(usual(setup))

    def standing_at(self, pose: Pose2) -> Standing:
        """Return how far a pose is confirmed that another filter holds for the robot's."""
        standing, places = self.filter.standing, self.filter.hypotheses
        only = bool(places) and places[0].weight > ONLY_PLACE
        if standing is Standing.LOST or (
            only and self.filter.setup.hypotheses.alike(places[0].pose, pose)
        ):
            return standing
        return Standing.UNCONFIRMED


def usual(setup: Setup) -> Setup:
    """Return a setup with the usual sensor model and parameters, on the same field and ranges.

    What another filter does not use (its parameters are idle), and a user's own sensor model, must
    not decide whether its place is confirmed. How far a step may err is the same for both.
    """
    given, start = setup.parameters, setup.filter
    sensor = SensorParameters(
        laser_min_range=given.sensor.laser_min_range,
        laser_max_range=given.sensor.laser_max_range,
        laser_likelihood_max_dist=given.sensor.laser_likelihood_max_dist,
        field_resolution=given.sensor.field_resolution,
    )
    parameters = LocalizationParameters(
        given.motion,
        sensor,
        FilterParameters(
            initial_sd_xy=start.initial_sd_xy, initial_sd_theta=start.initial_sd_theta
        ),
        HypothesisParameters(fit_sd=given.hypotheses.fit_sd, fit_gate=given.hypotheses.fit_gate),
    )
    model = sensor_model(sensor, setup.entries, setup.field.edges)
    return Setup.of(setup.field, setup.entries, setup.motion, model, parameters)
