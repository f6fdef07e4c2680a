"""Resampling: which particles go on, and how many are needed."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from robot.geometry import Array, wrap_angle
from robot.localization.estimate import Hypothesis
from robot.localization.particles.clusters import Clusters


def low_variance(weights: Array, count: int, rng: np.random.Generator) -> NDArray[np.intp]:
    """Indices (count,) of particles drawn by weight (Probabilistic Robotics, Table 4.4).

    One random number places an even comb over the weights (n,), which must sum to one; a particle
    of weight w is drawn floor(count w) or ceil(count w) times.
    """
    comb = (rng.random() + np.arange(count)) / count
    edges = np.cumsum(weights)
    # Rounding may leave the last edge a little below one.
    drawn: NDArray[np.intp] = np.searchsorted(edges, comb * edges[-1], side="right")
    return np.minimum(drawn, len(weights) - 1)


def effective_sample_size(weights: Array) -> float:
    """1 / sum w^2 of weights (n,) that sum to one: 1 (one particle counts) to n (all do)."""
    return float(1.0 / np.square(weights).sum())


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
    # Above the best of those that still count nothing can be: there the product would overflow.
    centred = np.minimum(log_likelihood - log_likelihood[weights > 0].max(), 0.0)

    def at(power: float) -> Array:
        product = weights * np.exp(power * centred)
        normalised: Array = product / product.sum()
        return normalised

    full = at(exponent)
    if effective_sample_size(full) >= effective:
        return full
    low, high = 0.0, exponent
    for _ in range(12):
        middle = (low + high) / 2
        if effective_sample_size(at(middle)) >= effective:
            low = middle
        else:
            high = middle
    return at(low)


def regularize(
    poses: Array,
    clusters: Clusters,
    labels: NDArray[np.int64],
    scale: float,
    rng: np.random.Generator,
) -> Array:
    """Spread the copies of a particle as wide as its cluster's other particles are apart.

    Copies of few particles die out at random along a direction that the scans say nothing of, as
    along a single wall, and the filter would be sure of what it never measured. The noise has the
    cluster's covariance times the squared bandwidth h = scale (4 / (n (d + 2)))^(1 / (d + 4)) with
    d = 3 (regularized particle filter; Musso, Oudjane and Le Gland 2001). Before, the copies are
    scaled about their mean so that with the noise they are as wide as the cluster was (shrinkage;
    West 1993): else it would grow with every scan wherever none holds it, without end.

    Args:
        poses: (n, 3) resampled particles.
        clusters: the clusters they were drawn from.
        labels: (n,) cluster of each, as in ``clusters.labels``.
        scale: 1 is best for a normal distribution, 0 is none.
        rng: the only source of chance.
    """
    spread = poses.copy()
    if scale == 0:
        return spread
    for place, one in enumerate(clusters.hypotheses):
        members = np.flatnonzero(labels == place)
        if len(members) > 1:
            noise = rng.standard_normal((len(members), 3))
            spread[members] = _spread(poses[members], one, scale, noise)
    return spread


MOST_STRETCH = 1.5
"""Copies that happen to lie close together are scaled by no more than this."""


def _spread(poses: Array, of: Hypothesis, scale: float, noise: Array) -> Array:
    bandwidth = min(scale * (4 / (5 * len(poses))) ** (1 / 7), 1.0)
    variances, axes = np.linalg.eigh(of.covariance)
    sd = np.sqrt(np.maximum(variances, 0.0))
    offsets = poses - of.pose.to_array()
    offsets[:, 2] = wrap_angle(offsets[:, 2])
    along = offsets @ axes
    middle, now = along.mean(axis=0), along.std(axis=0)
    wanted = math.sqrt(1 - bandwidth**2) * sd
    stretch = np.minimum(wanted / np.maximum(now, 1e-12), MOST_STRETCH)
    moved = middle + stretch * (along - middle) + bandwidth * sd * noise
    result: Array = of.pose.to_array() + moved @ axes.T
    result[:, 2] = wrap_angle(result[:, 2])
    return result
