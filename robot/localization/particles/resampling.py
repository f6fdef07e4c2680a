"""Resampling: which particles go on, and how many are needed."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from robot.geometry import Array
from robot.localization.kernels.combs import comb, tempered


def low_variance(weights: Array, count: int, rng: np.random.Generator) -> NDArray[np.int64]:
    """Indices (count,) of particles drawn by weight (Probabilistic Robotics, Table 4.4).

    One random number places an even comb over the weights (n,), which must sum to one; a particle
    of weight w is drawn floor(count w) or ceil(count w) times.
    """
    return comb(weights, count, rng.random())


def effective_sample_size(weights: Array) -> float:
    """1 / sum w^2 of weights (n,) that sum to one: 1 (one particle counts) to n (all do)."""
    return 1.0 / float(weights @ weights)


def joined_sample_size(effective: Sequence[float], weights: Array) -> float:
    """Of clouds joined into one, weighed by weights (n,), from those of each."""
    return float(weights.sum() ** 2 / (weights**2 / np.array(effective)).sum())


def kld_sample_size(bins: int, pf_err: float, pf_z: float) -> int:
    """Particles needed so that the sampled distribution is close to the true one.

    Probabilistic Robotics, Table 8.4 (Fox 2003): with them the Kullback-Leibler distance stays
    below ``pf_err`` with the probability of which ``pf_z`` is the upper normal quantile.

    Args:
        bins: cells of the state space with a particle in them.
        pf_err: greatest distance.
        pf_z: standard normal quantile.
    """
    if bins <= 1:
        return 1
    a = 2.0 / (9.0 * (bins - 1))
    return math.ceil((bins - 1) / (2.0 * pf_err) * (1.0 - a + math.sqrt(a) * pf_z) ** 3)


def temper(log_likelihood: Array, weights: Array, exponent: float, effective: float) -> Array:
    """New weights (n,), proportional to weight times likelihood to a power.

    The power is ``exponent``, or as much less as keeps the effective sample size above
    ``effective`` particles: a likelihood that is sharper than the cloud is dense would leave one
    particle, and that a random one. (Annealing the likelihood; Deutscher, Blake and Reid 2000.)
    """
    return tempered(log_likelihood, weights, exponent, effective)
