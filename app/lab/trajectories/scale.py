"""Fit a scale to an estimate, as one from a single camera needs it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from app.lab.trajectories.metrics import align, ate_rmse, rms
from app.lab.trajectories.trajectory import Trajectory

MUCH = 0.5
"""A scale is free if it leaves no more than this part of the error ..."""
OTHER = 0.05
"""... and if its logarithm differs from 0 by more than this: a smaller difference comes from a
wheel's radius or a lens, not from a unit."""


@dataclass(frozen=True, slots=True)
class ScaleFit:
    """The similarity transform, Sim(3), compared with the rigid motion."""

    scale: float
    """The factor to multiply the estimate's positions by."""
    rigid: float
    """Root mean square error [m] after the best rigid motion."""
    scaled: float
    """The same with the scale."""

    @property
    def is_free(self) -> bool:
        """Whether the estimate seems to have a scale of its own instead of metres."""
        return self.scaled <= MUCH * self.rigid and abs(math.log(self.scale)) > OTHER


def fit_scale(truth: Trajectory, estimate: Trajectory) -> ScaleFit:
    """Fit the scale by least squares, after Umeyama (PAMI 1991), equations 40 to 42.

    The best rotation is the same with and without a scale, so it is taken from `align`; then
    c = sum p_i . q_i / sum |q_i|^2, with p the true and q the aligned positions, each relative to
    its mean.

    Raises:
        TrajectoryError: not pairs, or they cannot be aligned.
    """
    aligned = align(truth, estimate).apply(estimate)
    true = truth.positions - truth.positions.mean(axis=0)
    result = aligned.positions - aligned.positions.mean(axis=0)
    scale = float(np.sum(true * result) / np.sum(result**2))
    scaled = rms(np.linalg.norm(scale * result - true, axis=1))
    return ScaleFit(scale, ate_rmse(truth, aligned), scaled)
