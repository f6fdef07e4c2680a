"""A field, scans of it, and sensor models to try on them."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import shapely
from places import MAPS

from robot.fields.edges import normals
from robot.fields.field_loading import load_field
from robot.fields.ray_casting import cast_rays
from robot.geometry import Array, Pose2, heading_vectors
from robot.localization.models.beam import Beam
from robot.localization.models.entry_field import EntryField
from robot.localization.models.sensor_models import SensorModel, SensorParameters, sensor_model
from robot.scan import Scan

FIELD = load_field("stub", MAPS)
PARAMETERS = SensorParameters()
ENTRIES = EntryField.build(
    FIELD,
    resolution=PARAMETERS.field_resolution,
    max_distance=PARAMETERS.laser_likelihood_max_dist,
)
BEARINGS = np.radians(np.linspace(-31, 31, 61))


def model_of(name: str, **changes: Any) -> SensorModel:
    parameters = replace(PARAMETERS, laser_model_type=name, **changes)
    return sensor_model(parameters, ENTRIES, FIELD.edges)


def beam_of(**changes: Any) -> Beam:
    made = sensor_model(
        replace(PARAMETERS, laser_model_type="beam", **changes), ENTRIES, FIELD.edges
    )
    assert isinstance(made, Beam)
    return made


def scan_at(
    pose: Pose2, *, ahead: float = 0.0, sd: float = 0.0, bearings: Array = BEARINGS
) -> Scan:
    """The scan that a perfect scanner (or one with noise [m]) makes at a pose."""
    ranges = np.empty((1, len(bearings)))
    start = pose @ Pose2(ahead)
    reach = PARAMETERS.laser_max_range
    cast_rays(start.to_array()[None], bearings, FIELD.edge_index, reach, ranges)
    noise = sd * np.random.default_rng(1).standard_normal(len(bearings))
    return Scan(0.0, bearings, ranges[0] + noise, Pose2(ahead))


def at(model: SensorModel, pose: Pose2, scan: Scan) -> float:
    return float(model.log_likelihood(pose.to_array()[None], scan)[0])


TRUTH = Pose2(0.1, -0.15, 0.4)


def entry_distances(ends: Array, headings: Array) -> Array:
    """By shapely: from each end the way to the nearest edge that its ray can enter by."""
    found = []
    facing_from = normals(FIELD.edges)
    for end, heading in zip(ends, headings, strict=True):
        toward = heading_vectors(np.array([round(heading / (math.pi / 4)) * math.pi / 4]))[0]
        facing = facing_from @ toward < math.sin(math.pi / 8)
        lines = shapely.linestrings(FIELD.edges[facing].reshape(-1, 2, 2))
        found.append(shapely.distance(lines, shapely.points(end)).min())
    return np.minimum(found, PARAMETERS.laser_likelihood_max_dist)
