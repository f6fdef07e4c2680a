"""Interface of all filters, a belief updated by odometry and scans; and the setup of a filter."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from robot.fields.field import Field
from robot.geometry import Array, Pose2, compose, covariance_root
from robot.localization.estimate import Hypothesis, Standing
from robot.localization.models.entry_field import EntryField
from robot.localization.models.motion_models import MotionModel
from robot.localization.models.sensor_models import SensorModel, sensor_model
from robot.localization.parameters import (
    FilterParameters,
    HypothesisParameters,
    LocalizationParameters,
)
from robot.localization.ray_evidence import RayEvidence
from robot.localization.scan_matching import ScanMatcher
from robot.scan import Scan


@dataclass(frozen=True)
class Setup:
    """Field, models and parameters of a filter.

    It is frozen: to change a model, give the filter another setup (``Filter.use``).
    """

    field: Field
    entries: EntryField
    motion: MotionModel
    sensor: SensorModel
    matcher: ScanMatcher
    """Lays rays on edges in a search, and at places that are known roughly."""
    fine_matcher: ScanMatcher
    """The same at places that are known to millimetres: its gate keeps rays off other edges."""
    evidence: RayEvidence
    """Weighs places."""
    parameters: LocalizationParameters

    @classmethod
    def of(
        cls,
        field: Field,
        entries: EntryField,
        motion: MotionModel,
        sensor: SensorModel,
        parameters: LocalizationParameters,
    ) -> Setup:
        """Return a setup with the matchers and the evidence that the parameters describe."""
        _ = entries.planes  # computed now, so that no frame has to wait for it
        reach, p = parameters.sensor.laser_max_range, parameters.hypotheses
        slope = parameters.sensor.sigma_slope
        return cls(
            field,
            entries,
            motion,
            sensor,
            ScanMatcher(field.edge_index, reach, p.fit_sd, p.fit_gate, slope),
            ScanMatcher(field.edge_index, reach, p.fit_sd, min(p.fit_gate, _half(field)), slope),
            RayEvidence.of(field, reach, p.fit_sd, slope),
            parameters,
        )

    @classmethod
    def of_field(
        cls, field: Field, parameters: LocalizationParameters, entries: EntryField | None = None
    ) -> Setup:
        """Return a setup on a field with the models that the parameters name.

        Args:
            field: where the robot drives.
            parameters: of models and filter.
            entries: the field's table of distances, if it exists already.
        """
        sensor = parameters.sensor
        if entries is None:
            entries = EntryField.build(
                field,
                resolution=sensor.field_resolution,
                max_distance=sensor.laser_likelihood_max_dist,
            )
        model = sensor_model(sensor, entries, field.edges)
        return cls.of(field, entries, parameters.motion.model(), model, parameters)

    @property
    def reach(self) -> tuple[float, float]:
        """Shortest and longest range that are trusted [m]."""
        return self.parameters.sensor.laser_min_range, self.parameters.sensor.laser_max_range

    @property
    def likelihood_weight(self) -> float:
        """Share of each ray's log-likelihood that counts."""
        return self.parameters.sensor.likelihood_weight

    @property
    def filter(self) -> FilterParameters:
        """Parameters of the filter."""
        return self.parameters.filter

    @property
    def hypotheses(self) -> HypothesisParameters:
        """Parameters of the hypotheses."""
        return self.parameters.hypotheses


def _half(field: Field) -> float:
    """Return half the narrowest tape's width [m].

    With a larger residual, the tape's other edge is nearer.
    """
    return min((kind.width for kind in field.tape), default=math.inf) / 2


@dataclass(frozen=True, slots=True, eq=False)
class Cloud:
    """Weighted poses that represent a belief; any filter can be displayed as one."""

    poses: Array = field(repr=False)
    """(n, 3) [m, m, rad] in the map."""
    weights: Array = field(repr=False)
    """(n,), summing to one."""

    @classmethod
    def even(cls, poses: Array) -> Cloud:
        """Return a cloud of equally weighted poses (n, 3)."""
        return cls(poses, np.full(len(poses), 1.0 / len(poses)))

    @classmethod
    def joined(cls, clouds: Sequence[Cloud], weights: Array) -> Cloud:
        """Join n clouds into one; ``weights`` (n,) are the clouds' relative weights."""
        shares = (weights / weights.sum()).tolist()
        parts = [cloud.weights * share for cloud, share in zip(clouds, shares, strict=True)]
        return cls(np.concatenate([cloud.poses for cloud in clouds]), np.concatenate(parts))

    @classmethod
    def drawn(
        cls, hypotheses: tuple[Hypothesis, ...], count: int, rng: np.random.Generator
    ) -> Cloud:
        """Draw about ``count`` poses from hypotheses, by weight, and at least one from each."""
        total = sum(hypothesis.weight for hypothesis in hypotheses)
        parts = []
        for item in hypotheses:
            share = max(1, round(count * item.weight / total))
            noise = rng.standard_normal((share, 3)) @ covariance_root(item.covariance).T
            parts.append(compose(item.pose.to_array() + noise, np.zeros(3)))
        return cls.even(np.concatenate(parts))


class Filter(Protocol):
    """A Bayes filter (Probabilistic Robotics, Table 2.1): predict with motion, correct by scans.

    ``Localizer`` decides when to predict and when to correct.
    """

    @property
    def cloud(self) -> Cloud:
        """The belief as weighted poses; after a scan, those from before the resampling."""
        ...

    @property
    def hypotheses(self) -> tuple[Hypothesis, ...]:
        """Where the robot may be, heaviest first; empty while nothing is known."""
        ...

    @property
    def effective(self) -> float:
        """Effective sample size: how many equally heavy particles the cloud is worth."""
        ...

    @property
    def standing(self) -> Standing:
        """State of the search for other places."""
        ...

    @property
    def extra_sd(self) -> float:
        """How much less the last scan's ranges were believed, as the belief is coarse [m]."""
        ...

    def use(self, setup: Setup) -> None:
        """Switch to other models and parameters, and keep the belief."""
        ...

    def loosen(self, factor: float) -> None:
        """Multiply the motion model's standard deviations by ``factor`` from now on."""
        ...

    def search_anew(self) -> None:
        """Note that the robot was probably carried off while it stood."""
        ...

    def set_pose(self, pose: Pose2, covariance: Array) -> None:
        """Restart around a pose in the map, with covariance (3, 3) [m, m, rad]."""
        ...

    def set_hypotheses(self, hypotheses: tuple[Hypothesis, ...]) -> None:
        """Restart at hypotheses; only the ratios of their weights count."""
        ...

    def set_cloud(self, cloud: Cloud) -> None:
        """Restart from weighted poses."""
        ...

    def scatter(self) -> None:
        """Restart without a known place: the robot may be anywhere on the field."""
        ...

    def predict(self, moved: Pose2) -> None:
        """Move the belief by a step of odometry, seen from the step's start."""
        ...

    def correct(self, scan: Scan) -> None:
        """Correct the belief by a scan."""
        ...
