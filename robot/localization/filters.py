"""The filters on offer, by name."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from robot.localization.filter import Filter
from robot.localization.grid.grid_filter import GridFilter
from robot.localization.hypotheses.multi_hypothesis import MultiHypothesisFilter
from robot.localization.kalman_filter import KalmanFilter
from robot.localization.particles.particle_filter import ParticleFilter
from robot.localization.setup import Setup


@dataclass(frozen=True, slots=True)
class ParticleTracks:
    """Makes particle filters that draw from one generator.

    No closure: what a filter holds can be kept and brought back, with the generator.
    """

    rng: np.random.Generator

    def __call__(self, setup: Setup, share: float) -> ParticleFilter:
        """One that keeps a share of the particles."""
        return ParticleFilter.of(setup, self.rng, share)


MAKERS: dict[str, Callable[[Setup, np.random.Generator], Filter]] = {
    "hypotheses": lambda setup, rng: MultiHypothesisFilter(setup, ParticleTracks(rng), rng),
    "particles": ParticleFilter.of,
    "kalman": KalmanFilter.of,
    "grid": lambda setup, _: GridFilter.of(setup),
}

SAID = 0.9
"""A filter with so much of its weight in hypotheses has said by them what it believes."""


def make_filter(setup: Setup, rng: np.random.Generator) -> Filter:
    """The filter that the parameters ask for, at the field's start."""
    return MAKERS[setup.filter.filter](setup, rng)


def going_on(new: Filter, old: Filter) -> Filter:
    """Let a filter go on from what another believes."""
    said = old.hypotheses
    if sum(item.weight for item in said) >= SAID:
        new.set_hypotheses(said)
    else:
        new.set_cloud(old.cloud)
    return new
