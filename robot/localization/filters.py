"""The available filters, by name."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from robot.localization.filter import Filter, Setup
from robot.localization.grid.grid_filter import GridFilter
from robot.localization.hypotheses.multi_hypothesis import MultiHypothesisFilter
from robot.localization.kalman_filter import KalmanFilter
from robot.localization.particles.particle_filter import ParticleFilter


@dataclass(frozen=True, slots=True)
class ParticleTracks:
    """Factory of particle filters that share one random generator.

    It is a class and not a closure, so that a checkpoint can save and restore it with a filter.
    """

    rng: np.random.Generator

    def __call__(self, setup: Setup, share: float) -> ParticleFilter:
        """Return a filter with a share of the usual number of particles."""
        return ParticleFilter.of(setup, self.rng, share)


MAKERS: dict[str, Callable[[Setup, np.random.Generator], Filter]] = {
    "hypotheses": lambda setup, rng: MultiHypothesisFilter(setup, ParticleTracks(rng), rng),
    "particles": ParticleFilter.of,
    "kalman": KalmanFilter.of,
    "grid": lambda setup, _: GridFilter.of(setup),
}

MIN_DESCRIBED_WEIGHT = 0.9
"""From this total weight on, the hypotheses alone describe a filter's belief."""


def make_filter(setup: Setup, rng: np.random.Generator) -> Filter:
    """Return the filter that the parameters name, at the field's start pose."""
    return MAKERS[setup.filter.filter](setup, rng)


def transfer_belief(new: Filter, old: Filter) -> Filter:
    """Give a new filter the belief of an old one, and return it."""
    said = old.hypotheses
    if sum(item.weight for item in said) >= MIN_DESCRIBED_WEIGHT:
        new.set_hypotheses(said)
    else:
        new.set_cloud(old.cloud)
    return new
