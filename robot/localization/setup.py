"""Setup of a filter: the field, the models and the parameters."""

from __future__ import annotations

import math
from dataclasses import dataclass

from robot.fields.field import Field
from robot.localization.models.entry_field import EntryField
from robot.localization.models.motion_models import MotionModel
from robot.localization.models.sensor_models import SensorModel
from robot.localization.parameters import (
    FilterParameters,
    HypothesisParameters,
    LocalizationParameters,
)
from robot.localization.ray_evidence import RayEvidence
from robot.localization.scan_matching import ScanMatcher


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
