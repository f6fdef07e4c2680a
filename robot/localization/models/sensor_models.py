"""Sensor models: how well does a scan fit a pose?

A sensor model has ``log_likelihood``; a student's own is the same thing. What depends on the scan
alone is done once, before the work that is done for each particle.
"""

from __future__ import annotations

from typing import Protocol, runtime_checkable

import numpy as np

from robot.fields.edge_index import index_edges
from robot.geometry import Array
from robot.localization.models.beam import Beam
from robot.localization.models.entry_field import EntryField
from robot.localization.models.likelihood_field import LikelihoodField
from robot.localization.models.likelihood_field_prob import LikelihoodFieldProb
from robot.localization.models.sensor_parameters import SensorParameters
from robot.scan import Scan


class SensorModel(Protocol):
    """What any sensor model offers."""

    def log_likelihood(self, poses: Array, scan: Scan) -> Array:
        """Log-likelihood (n,) of a scan at poses (n, 3), up to a constant."""
        ...


@runtime_checkable
class RayCounting(Protocol):
    """What a sensor model may offer besides; those that come with the program do."""

    def count_rays(self, poses: Array, scan: Scan) -> int:
        """How many rays of a scan the log-likelihood at poses (n, 3) is the sum of."""
        ...


def count_rays(model: SensorModel, poses: Array, scan: Scan) -> int:
    """How many rays of a scan a model's log-likelihood at poses (n, 3) is the sum of.

    One that does not say, as a user's own, is taken to count all that returned.
    """
    if isinstance(model, RayCounting):
        return model.count_rays(poses, scan)
    return int(np.count_nonzero(scan.hit))


def sensor_model(parameters: SensorParameters, entries: EntryField, edges: Array) -> SensorModel:
    """The model that the parameters ask for."""
    field = LikelihoodField(
        entries,
        parameters.sigma_hit,
        parameters.z_hit,
        parameters.z_rand,
        parameters.laser_max_range,
        parameters.max_beams,
        parameters.sigma_slope,
    )
    match parameters.laser_model_type:
        case "beam":
            return _beam(parameters, edges)
        case "likelihood_field_prob":
            return LikelihoodFieldProb(
                field,
                parameters.do_beamskip,
                parameters.beam_skip_distance,
                parameters.beam_skip_threshold,
                parameters.beam_skip_error_threshold,
            )
    return field


def _beam(parameters: SensorParameters, edges: Array) -> Beam:
    return Beam(
        index_edges(edges),
        parameters.sigma_hit,
        parameters.z_hit,
        parameters.z_short,
        parameters.z_max,
        parameters.z_rand,
        parameters.lambda_short,
        parameters.laser_max_range,
        parameters.max_beams,
    )
