"""Sensor models: how well a scan fits a pose; and their parameters.

A sensor model has the method ``log_likelihood``; a student's own model is used in the same way.
Work that depends on the scan alone is done once, before the work for each particle. The parameters
have nav2_amcl's names; only those that a camera needs have names of their own.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np

from robot.fields.edge_index import index_edges
from robot.geometry import Array
from robot.localization.models.beam import Beam
from robot.localization.models.entry_field import EntryField
from robot.localization.models.likelihood_field import LikelihoodField
from robot.localization.models.likelihood_field_prob import LikelihoodFieldProb
from robot.scan import Scan
from robot.settings import check_settings, setting

SENSOR_MODELS = ("likelihood_field", "likelihood_field_prob", "beam")


@dataclass(frozen=True)
class SensorParameters:
    """Parameters of the sensor models: how scans err."""

    laser_model_type: str = setting(
        "likelihood_field", "How well a scan fits a pose", choices=SENSOR_MODELS
    )
    sigma_hit: float = setting(
        0.003, "Spread of a range that hit an edge of the map", unit="m", low=0.0005, high=0.5
    )
    sigma_slope: float = setting(
        8.0,
        "How that grows with a range r, as 1 + slope r²: the farther the floor, the more of it a "
        "pixel sees, and the more a camera askew misplaces it (likelihood fields); 0 is a laser's",
        unit="1/m²",
        low=0,
        high=100,
    )
    z_hit: float = setting(0.95, "Share of ranges that hit an edge of the map", low=0, high=1)
    z_rand: float = setting(0.05, "Share of ranges that are false", low=0.001, high=1)
    z_short: float = setting(
        0.05, "Share of ranges cut short by something not in the map (beam)", low=0, high=1
    )
    z_max: float = setting(
        0.05, "Share of rays that miss an edge they should have met (beam)", low=0.001, high=1
    )
    lambda_short: float = setting(
        5.0,
        "How quickly short ranges become rare with distance (beam)",
        unit="1/m",
        low=0.01,
        high=100,
    )
    max_beams: int = setting(60, "Rays used of each scan", low=3, high=720)
    do_beamskip: bool = setting(
        False, "Skip rays that hardly any particle can explain (likelihood_field_prob)"
    )
    beam_skip_distance: float = setting(
        0.02, "A ray that ends closer to an edge agrees with a particle", unit="m",
        low=0.001, high=2,
    )  # fmt: skip
    beam_skip_threshold: float = setting(
        0.3, "Rays that agree with no greater share of the particles are skipped", low=0, high=1
    )
    beam_skip_error_threshold: float = setting(
        0.9, "If this share of the rays would be skipped, none is", low=0, high=1
    )
    likelihood_weight: float = setting(
        0.2,
        "Share of each ray's log-likelihood that counts, as neighbouring rays err together",
        low=0.001,
        high=1,
    )
    laser_min_range: float = setting(0.0, "Nearer returns are left out", unit="m", low=0, high=100)
    laser_max_range: float = setting(
        1.0, "Longest range; farther returns count as none", unit="m", low=0.05, high=100
    )
    laser_likelihood_max_dist: float = setting(
        0.15, "Ends farther from an edge than this count alike", unit="m", low=0.01, high=2
    )
    field_resolution: float = setting(
        0.005, "Cell of the table of distances", unit="m", low=0.002, high=0.5
    )

    def __post_init__(self) -> None:
        check_settings(self)


class SensorModel(Protocol):
    """The interface of a sensor model."""

    def log_likelihood(self, poses: Array, scan: Scan) -> Array:
        """Return the log-likelihood (n,) of a scan at poses (n, 3), up to a constant."""
        ...


@runtime_checkable
class RayCounting(Protocol):
    """An optional part of a sensor model; the built-in models have it."""

    def count_rays(self, poses: Array, scan: Scan) -> int:
        """Return how many rays the log-likelihood at poses (n, 3) is the sum of."""
        ...


def count_rays(model: SensorModel, poses: Array, scan: Scan) -> int:
    """Return how many rays a model's log-likelihood at poses (n, 3) is the sum of.

    If the model does not say, such as a user's own, these are all rays that returned.
    """
    if isinstance(model, RayCounting):
        return model.count_rays(poses, scan)
    return int(np.count_nonzero(scan.hit))


def sensor_model(parameters: SensorParameters, entries: EntryField, edges: Array) -> SensorModel:
    """Return the model that the parameters choose."""
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
