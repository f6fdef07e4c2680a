"""How well single poses fit a scan, ray by ray, for the page's question to a particle."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from robot.fields.edge_index import EdgeIndex
from robot.fields.ray_casting import cast_toward
from robot.geometry import Array, Pose2, heading_vectors
from robot.localization.models.beam import Beam
from robot.localization.models.likelihood_field import LikelihoodField
from robot.localization.models.likelihood_field_prob import LikelihoodFieldProb
from robot.localization.models.sensor_models import SensorModel
from robot.scan import Scan


@dataclass(frozen=True, slots=True)
class Weighing:
    """The newest scan, with the model and the power that weigh particles."""

    scan: Scan = field(repr=False)
    """As the filter takes it."""
    model: SensorModel = field(repr=False)
    power: float
    """Share of the log-likelihood that counts in a weight."""
    best: Pose2 | None
    """The estimate at the scan's stamp."""

    def settled(self, poses: Array) -> Weighing:
        """Return a copy in which the rays count as they did for a cloud (n, 3), at any poses."""
        if not isinstance(self.model, LikelihoodFieldProb):
            return self
        scan = self.model.without_skipped(poses, self.scan)
        return replace(self, scan=scan, model=self.model.plain)

    def asking(self, model: SensorModel) -> Weighing:
        """Return a copy with another model."""
        return replace(self, model=model)

    @property
    def counted(self) -> NDArray[np.intp]:
        """Indices of the rays that count; all rays for a user's own model."""
        if isinstance(self.model, LikelihoodField | Beam):
            return self.model.counted(self.scan)
        return np.arange(len(self.scan.ranges))

    def log_likelihoods(self, poses: Array) -> Array:
        """Return the log-likelihood (n,) of the scan at poses (n, 3), up to a constant."""
        return self.model.log_likelihood(poses, self.scan.only(self.counted))

    def shares(self, poses: Array) -> Array:
        """Return the log-likelihood (n, k) of each ray; nan for a ray that does not count.

        The sum is the log-likelihood of the scan, for a model whose rays err independently.
        """
        result = np.full((len(poses), len(self.scan.ranges)), np.nan)
        for ray in self.counted:
            alone = self.scan.only(np.array([ray]))
            result[:, ray] = self.model.log_likelihood(poses, alone)
        return result

    def expected(self, pose: Pose2, index: EdgeIndex, range_max: float) -> Array:
        """Return the ranges (k,) [m] expected at a pose; +inf where no edge is in sight."""
        scan = self.scan
        start = pose @ scan.robot_from_scan
        toward = heading_vectors(start.theta + scan.bearings)
        sight = np.zeros(len(toward)) if scan.sight is None else scan.sight[:, 0]
        expected = np.full(len(toward), np.inf)
        for ray, ((dx, dy), near) in enumerate(zip(toward.tolist(), sight.tolist(), strict=True)):
            if not np.isnan(near):
                x, y = start.x + near * dx, start.y + near * dy
                expected[ray] = near + cast_toward(x, y, dx, dy, index, range_max - near)[0]
        return expected
