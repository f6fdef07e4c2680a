"""What every filter is given: the field, the models and the parameters."""

from __future__ import annotations

import math
from dataclasses import dataclass

from robot.fields.field import Field
from robot.localization.hypothesis_parameters import HypothesisParameters
from robot.localization.models.entry_field import EntryField
from robot.localization.models.motion_models import MotionModel
from robot.localization.models.sensor_models import SensorModel
from robot.localization.parameters import FilterParameters, LocalizationParameters
from robot.localization.ray_evidence import RayEvidence
from robot.localization.scan_matching import ScanMatcher


@dataclass(frozen=True)
class Setup:
    """Frozen: to change a model, a filter is told to go on with another setup."""

    field: Field
    entries: EntryField
    motion: MotionModel
    sensor: SensorModel
    matcher: ScanMatcher
    """Lays rays on edges where places are looked for."""
    fine_matcher: ScanMatcher
    """The same at places that are known to millimetres: rays are not laid on another edge."""
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
        """With matcher and evidence as the parameters ask for."""
        _ = entries.planes  # made now, and not while a frame waits for it
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
        """Shortest and longest range that are believed [m]."""
        return self.parameters.sensor.laser_min_range, self.parameters.sensor.laser_max_range

    @property
    def likelihood_weight(self) -> float:
        """Share of each ray's log-likelihood that counts."""
        return self.parameters.sensor.likelihood_weight

    @property
    def filter(self) -> FilterParameters:
        """Those of the particle filter."""
        return self.parameters.filter

    @property
    def hypotheses(self) -> HypothesisParameters:
        """Those of the hypotheses."""
        return self.parameters.hypotheses


def _half(field: Field) -> float:
    """Half the width of the tape [m]: farther off, a ray is nearer to its other edge."""
    return math.inf if field.tape_width is None else field.tape_width / 2
