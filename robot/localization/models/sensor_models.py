"""Sensor models: how well does a scan fit a pose?

A sensor model has ``log_likelihood``; a student's own is the same thing. What depends on the scan
alone is done once, before the work that is done for each particle.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
from numba import njit

from robot.fields.edge_index import index_edges
from robot.geometry import Array
from robot.localization.models.beam import Beam
from robot.localization.models.entry_field import EntryField
from robot.localization.models.likelihood_field import LikelihoodField
from robot.localization.models.likelihood_field_prob import LikelihoodFieldProb
from robot.localization.parameters import SensorParameters
from robot.scan import Scan


class SensorModel(Protocol):
    """What any sensor model offers."""

    def log_likelihood(self, poses: Array, scan: Scan) -> Array:
        """Log-likelihood (n,) of a scan at poses (n, 3), up to a constant."""
        ...


@dataclass(frozen=True)
class WithinRange:
    """A sensor model that is shown only ranges of a certain length, as nav2 does.

    A return from nearer says nothing: its ray is left out. One from farther is no return.
    """

    model: SensorModel
    low: float
    """[m]"""
    high: float
    """[m]"""

    def log_likelihood(self, poses: Array, scan: Scan) -> Array:
        """Log-likelihood (n,) of a scan at poses (n, 3), up to a constant."""
        return self.model.log_likelihood(poses, self._limited(scan))

    def _limited(self, scan: Scan) -> Scan:
        if _all_within(scan.ranges, self.low, self.high):
            return scan  # mostly so, and copies would take a tenth of a small filter's update
        kept, far = scan.ranges >= self.low, scan.ranges > self.high
        ranges = np.where(far, np.inf, scan.ranges)
        return replace(
            scan,
            bearings=scan.bearings[kept],
            ranges=ranges[kept],
            sight=None if scan.sight is None else scan.sight[kept],
        )


@njit(cache=True, nogil=True)
def _all_within(ranges: Array, low: float, high: float) -> bool:
    """Whether each range is in bounds or no return; compiled, as it is asked with every scan."""
    for distance in ranges:  # noqa: SIM110 (numba has no generators here)
        if not (low <= distance <= high or distance == math.inf):
            return False
    return True


def sensor_model(parameters: SensorParameters, entries: EntryField, edges: Array) -> WithinRange:
    """The model that the parameters ask for, within their range."""
    model = _model(parameters, entries, edges)
    return WithinRange(model, parameters.laser_min_range, parameters.laser_max_range)


def _model(parameters: SensorParameters, entries: EntryField, edges: Array) -> SensorModel:
    field = LikelihoodField(
        entries,
        parameters.sigma_hit,
        parameters.z_hit,
        parameters.z_rand,
        parameters.laser_max_range,
        parameters.max_beams,
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
