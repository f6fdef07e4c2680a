"""Run a filter on a recorded drive: its hypotheses at each picture, and whether they are right."""

from __future__ import annotations

import gc
import math
import time
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from app.features.lab.evaluation.drives import Drive
from app.features.lab.evaluation.runs import PLACE_THETA, PLACE_XY
from robot.fields.field import Field
from robot.geometry import Array, Pose2
from robot.localization.estimate import ONLY_PLACE, Estimate, Hypothesis
from robot.localization.filter import Setup
from robot.localization.localizer import Localizer, make_filter
from robot.localization.models.entry_field import EntryField
from robot.localization.models.sensor_models import sensor_model
from robot.localization.parameters import LocalizationParameters
from robot.localization.refinement import Refinement

LOADING = 150
"""Number of ticks that use every part of a filter at least once."""
_LOADED: set[str] = set()
_ENTRIES: dict[tuple[str, float, float], EntryField] = {}
"""Distance tables already built, by field, resolution and largest distance."""


@dataclass(frozen=True, slots=True)
class PictureResult:
    """The hypotheses at one picture, and the truth at that moment."""

    stamp: float
    truth: Pose2
    hypotheses: tuple[Hypothesis, ...]
    """The heaviest first; empty while nothing is known."""
    cpu: float
    """Computing time of the filter [s]."""

    @property
    def error(self) -> float:
        """Distance of the heaviest hypothesis from the truth [m]; inf without one."""
        return self.hypotheses[0].pose.distance_to(self.truth) if self.hypotheses else math.inf

    @property
    def turn_error(self) -> float:
        """Heading error of the heaviest hypothesis [rad]; inf without one."""
        return abs(self.hypotheses[0].pose.turn_to(self.truth)) if self.hypotheses else math.inf

    @property
    def right(self) -> bool:
        """Whether the heaviest hypothesis is right."""
        return bool(self.hypotheses) and is_right(self.hypotheses[0].pose, self.truth)

    @property
    def claim(self) -> float:
        """Weight of the heaviest hypothesis; 0 without one."""
        return self.hypotheses[0].weight if self.hypotheses else 0.0


def is_right(pose: Pose2, truth: Pose2) -> bool:
    """Whether a pose is close to the truth."""
    return pose.distance_to(truth) < PLACE_XY and abs(pose.turn_to(truth)) < PLACE_THETA


def try_filter(
    drive: Drive,
    parameters: LocalizationParameters,
    seed: int,
    start: Pose2 | None = None,
    covariance: Array | None = None,
    setup: Setup | None = None,
) -> list[PictureResult]:
    """Run a filter over a drive.

    Args:
        drive: what the robot saw.
        parameters: which filter, and its settings.
        seed: of the filter's random numbers.
        start: the pose at the start; None scatters the filter over the field.
        covariance: of the start pose; None means that of the parameters.
        setup: models that replace those of the parameters.
    """
    setup = setup or setup_of(drive.field, parameters)
    load_compiled(setup, drive)
    localizer = Localizer(
        make_filter(setup, np.random.default_rng(seed)),
        parameters.filter,
        Refinement.of(setup),
        setup.reach,
    )
    if start is None:
        localizer.scatter()
    else:
        localizer.set_pose(start, covariance)
    shown: list[PictureResult] = []
    last: tuple[Estimate, Pose2] | None = None
    for tick in drive.ticks:
        if tick.scan is None or tick.odometry_at_scan is None:
            continue
        began = time.thread_time()
        estimate = localizer.update(tick.odometry_at_scan, tick.scan)
        took = time.thread_time() - began
        if estimate is not None:
            last = estimate, tick.odometry_at_scan
        hypotheses = carried(*last, tick.odometry_at_scan) if last else ()
        shown.append(
            PictureResult(tick.scan.stamp, drive.truth_at(tick.scan.stamp), hypotheses, took)
        )
    return shown


def load_compiled(setup: Setup, drive: Drive) -> None:
    """Use compiled code once in each process, so that loading it from disk is not measured."""
    if setup.filter.filter in _LOADED:
        return
    _LOADED.add(setup.filter.filter)
    localizer = Localizer(make_filter(setup, np.random.default_rng(0)), setup.filter)
    localizer.scatter()
    for tick in drive.ticks[:LOADING]:
        if tick.scan is not None and tick.odometry_at_scan is not None:
            localizer.update(tick.odometry_at_scan, tick.scan)
    gc.freeze()  # as the engine does


def carried(estimate: Estimate, odometry: Pose2, later_odometry: Pose2) -> tuple[Hypothesis, ...]:
    """Return the hypotheses of an estimate, moved on by odometry."""
    step = odometry.inverse() @ later_odometry
    return tuple(Hypothesis(h.weight, h.pose @ step, h.covariance) for h in estimate.hypotheses)


def setup_of(field: Field, parameters: LocalizationParameters) -> Setup:
    """Return everything that a filter needs; distance tables are kept."""
    sensor = parameters.sensor
    made = field.name, sensor.field_resolution, sensor.laser_likelihood_max_dist
    if made not in _ENTRIES:
        _ENTRIES[made] = EntryField.build(field, resolution=made[1], max_distance=made[2])
    entries = _ENTRIES[made]
    return Setup.of(
        field,
        entries,
        parameters.motion.model(),
        sensor_model(sensor, entries, field.edges),
        parameters,
    )


def right_for_good(shown: list[PictureResult], since: float) -> float:
    """Return the stamp [s] from which on the filter is right to the end; inf if it ends wrong."""
    stamp = math.inf
    for picture in reversed(shown):
        if not picture.right or picture.stamp < since:
            break
        stamp = picture.stamp
    return stamp


def wrong_first_claim(shown: list[PictureResult]) -> bool:
    """Whether the first claim to be certain was wrong."""
    claims = [picture.right for picture in shown if picture.claim > ONLY_PLACE]
    return bool(claims) and not claims[0]


@dataclass
class WeightCalibration:
    """Weights of hypotheses against how often these are right."""

    claimed: list[float] = field(default_factory=list)
    right: list[bool] = field(default_factory=list)

    def __add__(self, other: WeightCalibration) -> WeightCalibration:
        return WeightCalibration(self.claimed + other.claimed, self.right + other.right)

    def add(self, shown: list[PictureResult]) -> None:
        """Add every hypothesis of every picture."""
        for picture in shown:
            for hypothesis in picture.hypotheses:
                self.claimed.append(hypothesis.weight)
                self.right.append(is_right(hypothesis.pose, picture.truth))

    def table(self, borders: tuple[float, ...]) -> list[tuple[float, float, int]]:
        """Return mean weight, share that is right, and number, between borders of weights."""
        claimed, right = np.array(self.claimed), np.array(self.right)
        rows = []
        for low, high in pairwise(borders):
            some = (claimed >= low) & (claimed < high)
            if some.any():
                rows.append(
                    (float(claimed[some].mean()), float(right[some].mean()), int(some.sum()))
                )
        return rows
