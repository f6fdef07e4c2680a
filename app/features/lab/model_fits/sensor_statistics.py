"""Statistics of the scanner and of the beam model, from measured and exact ranges."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from app.features.lab.evaluation.drives import EvaluationError, record
from app.features.lab.evaluation.experiment import in_world
from app.features.lab.model_fits.beam_correlation import BeamCorrelation, correlate_beams
from app.features.lab.model_fits.beam_fit import SensorFit, fit_sensor
from app.features.lab.model_fits.range_pairs import (
    RangePairs,
    RangeStatistics,
    by_bearing,
    by_distance,
    overall,
    pair_ranges,
)
from app.features.lab.workers import Workers
from app.settings.config import MAPS, Config
from robot.fields.field_loading import load_field
from robot.geometry import Pose2
from robot.scan import Scan

DISTANCES = np.arange(0.1, 1.01, 0.1)
"""Borders of bins [m]."""
BEARINGS = np.radians(np.arange(-40, 41, 10))
"""Borders of bins [rad]."""
LEAST_SIGMA = 0.002
"""Smallest sigma_hit of a filter [m]: with less, no particle fits the ranges, and the filter loses
a place if it starts a little off (docs/evaluation.md)."""


@dataclass(frozen=True)
class SensorStatistics:
    """The errors of ranges, and the beam model's parameters."""

    pairs: RangePairs
    all: RangeStatistics
    distances: tuple[RangeStatistics, ...]
    bearings: tuple[RangeStatistics, ...]
    correlation: BeamCorrelation
    fit: SensorFit
    """The parameters that describe the scanner."""
    usable: SensorFit
    """The same with a sigma_hit that a filter can use."""


def scans_of(job: tuple[Config, float]) -> tuple[list[Scan], list[Pose2]]:
    """Return the scans of a figure-eight, and the true pose at each scan's stamp."""
    drive = record(*job)
    scans = [tick.scan for tick in drive.ticks if tick.scan is not None]
    return scans, [drive.truth_at(scan.stamp) for scan in scans]


def scanned_drives(
    config: Config, world: str, drives: int, seconds: float, workers: Workers
) -> SensorStatistics:
    """Compare the scans of several figure-eights of one simulated robot, each for some seconds.

    Raises:
        EvaluationError: a drive cannot be made.
        FitError: the ranges show no edges.
    """
    config = in_world(config, world)
    seeds = range(config.seed, config.seed + drives)
    jobs = [(replace(config, seed=seed), seconds) for seed in seeds]
    scans: list[Scan] = []
    poses: list[Pose2] = []
    for place, result in sorted(workers.each(scans_of, jobs), key=lambda pair: pair[0]):
        if isinstance(result, Exception):
            raise EvaluationError(f"seed {seeds[place]}: {result}") from result
        scans += result[0]
        poses += result[1]
    sensor = config.localization.sensor
    range_max = sensor.laser_max_range
    pairs = pair_ranges(load_field(config.map, MAPS), scans, poses, range_max)
    correlation = correlate_beams(pairs, sensor.max_beams)
    worth = correlation.likelihood_weight_of_successive_scans
    return SensorStatistics(
        pairs,
        overall(pairs),
        tuple(by_distance(pairs, DISTANCES)),
        tuple(by_bearing(pairs, BEARINGS)),
        correlation,
        fit_sensor(pairs, range_max, worth=worth),
        fit_sensor(pairs, range_max, worth=worth, least_sigma=LEAST_SIGMA),
    )
