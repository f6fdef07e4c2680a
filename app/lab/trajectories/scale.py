"""How much better an estimate fits with a scale of its own, as one of a single camera needs."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from app.lab.trajectories.metrics import align, ate_rmse, rms
from app.lab.trajectories.trajectory import Trajectory

MUCH = 0.5
"""A scale is worth a word if it leaves no more than such a part of the error ..."""
OTHER = 0.05
"""... and differs by more than such a part: less is a wheel's radius or a lens, not a unit."""


@dataclass(frozen=True, slots=True)
class ScaleFit:
    """The similarity transform, Sim(3), beside the rigid motion."""

    scale: float
    """What the estimate's positions are to be multiplied by."""
    rigid: float
    """Root mean square error [m] after the rigid motion that makes it least."""
    scaled: float
    """The same with the scale."""

    @property
    def is_free(self) -> bool:
        """Whether the estimate's scale seems to be its own, not metres."""
        return self.scaled <= MUCH * self.rigid and abs(math.log(self.scale)) > OTHER


def fit_scale(truth: Trajectory, estimate: Trajectory) -> ScaleFit:
    """The scale of least squares, after Umeyama (PAMI 1991), equations 40 to 42.

    The best rotation is the same with and without a scale, so it is taken from `align`; then
    c = sum p_i . q_i / sum |q_i|^2, with p true and q turned positions, each from its middle.

    Raises:
        TrajectoryError: not pairs, or they cannot be aligned.
    """
    aligned = align(truth, estimate).apply(estimate)
    true = truth.positions - truth.positions.mean(axis=0)
    result = aligned.positions - aligned.positions.mean(axis=0)
    scale = float(np.sum(true * result) / np.sum(result**2))
    scaled = rms(np.linalg.norm(scale * result - true, axis=1))
    return ScaleFit(scale, ate_rmse(truth, aligned), scaled)
