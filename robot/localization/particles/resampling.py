"""Resampling: temper the weights, choose the sample size, draw particles and spread their copies.

Also recovery: random particles are added when the latest scans fit worse than earlier ones.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robot.compiling import compiled
from robot.geometry import Array
from robot.localization.kernels.sampling import comb, noise_key, tempered
from robot.localization.kernels.spread_copies import spread_copies
from robot.localization.particles.clusters import Clusters


@dataclass
class Recovery:
    """Augmented MCL (Probabilistic Robotics, Table 8.3; nav2_amcl's recovery_alpha).

    It keeps two running averages of the likelihood of scans. If the fast one falls below the slow
    one, random poses replace 1 - fast / slow of the particles.
    """

    slow: float = 0.0
    fast: float = 0.0

    def observe(
        self, log_likelihood: Array, weights: Array, rays: int, alpha_slow: float, alpha_fast: float
    ) -> None:
        """Add a scan to both averages.

        The value is the geometric mean of the likelihoods of its rays. So scans with few rays and
        with many can be compared, and no ray outweighs all the others.

        Args:
            log_likelihood: (n,) of the whole scan, for each particle.
            weights: (n,) of the particles before the scan; they sum to one.
            rays: number of rays in that sum.
            alpha_slow: share of the new value in the slow average; 0 turns recovery off.
            alpha_fast: share of the new value in the fast average; 0 turns recovery off.
        """
        if alpha_slow == 0 or alpha_fast == 0:
            return
        average = float(weights @ np.exp(log_likelihood / max(rays, 1)))
        self.slow += (alpha_slow if self.slow else 1.0) * (average - self.slow)
        self.fast += (alpha_fast if self.fast else 1.0) * (average - self.fast)

    def share(self) -> float:
        """Return the share of the particles to replace by random ones."""
        return max(0.0, 1.0 - self.fast / self.slow) if self.slow > 0 else 0.0


@compiled()
def coarseness(
    weights: Array, covariances: Array, particles: int, ranges: Array
) -> tuple[float, int]:
    """Return the distance between neighbouring particles [m], and how many rays returned.

    A likelihood that is narrower than this distance falls between the particles. So while the cloud
    is wide, this distance is added to the spread of the ranges. Angles count by how far they move
    the end of a typical ray. If no ray returned, both values are 0.

    Args:
        weights: (k,) share of the weight in each cluster.
        covariances: (k, 3, 3) of the clusters [m, m, rad].
        particles: number of particles in all clusters.
        ranges: (r,) lengths of the rays [m], +inf where nothing returned.
    """
    returned = ranges[np.isfinite(ranges)]
    if not len(returned):
        return 0.0, 0
    reach = np.median(returned)
    apart = 0.0
    for k in range(len(weights)):
        (xx, xy, xt), (_, yy, yt), (_, _, tt) = covariances[k]
        determinant = xx * (yy * tt - yt * yt) - xy * (xy * tt - yt * xt) + xt * (xy * yt - yy * xt)
        volume = math.sqrt(max(determinant, 0.0)) * reach
        apart += weights[k] * (volume / max(weights[k] * particles, 1.0)) ** (1 / 3)
    return float(apart), len(returned)


@dataclass(frozen=True, slots=True, eq=False)
class Resampled:
    """Which particles were drawn; their copies may be in another order."""

    clusters: Clusters
    """Clusters of the particles before resampling."""
    drawn: NDArray[np.int64]
    """(m,) as ``low_variance`` drew them."""
    renewed: NDArray[np.bool_]
    """(m,) which of the new particles were replaced by random poses."""
    in_order: bool
    """Whether the copies are in the order in which they were drawn; spread copies are not."""

    @property
    def parents(self) -> NDArray[np.int64]:
        """The particle that each new one is a copy of (m,); -1 for a random pose."""
        parents = self.drawn
        if not self.in_order:
            # Copies of a cluster stand side by side; see ``spread_copies``.
            cluster = np.minimum(self.clusters.labels[parents], len(self.clusters.means))
            parents = parents[np.argsort(cluster, kind="stable")]
        return np.where(self.renewed, -1, parents)


def low_variance(weights: Array, count: int, rng: np.random.Generator) -> NDArray[np.int64]:
    """Draw particles by weight and return their indices (count,) (Table 4.4).

    One random number shifts an even comb over the weights (n,), which must sum to one. A particle
    of weight w is drawn floor(count w) or ceil(count w) times.
    """
    return comb(weights, count, rng.random())


def effective_sample_size(weights: Array) -> float:
    """Return 1 / sum w^2 of weights (n,) that sum to one: 1 if one particle counts, n if all do."""
    return 1.0 / float(weights @ weights)


def joined_sample_size(effective: Sequence[float], weights: Array) -> float:
    """Return the effective sample size of joined clouds, from those of each and their weights."""
    return float(weights.sum() ** 2 / (weights**2 / np.array(effective)).sum())


def kld_sample_size(bins: int, pf_err: float, pf_z: float) -> int:
    """Return how many particles keep the sampled distribution close to the true one.

    With so many particles, the Kullback-Leibler distance stays below ``pf_err`` with the
    probability that belongs to the quantile ``pf_z`` (Table 8.4; Fox 2003).

    Args:
        bins: number of cells of the state space that hold a particle.
        pf_err: largest distance.
        pf_z: standard normal quantile.
    """
    if bins <= 1:
        return 1
    a = 2.0 / (9.0 * (bins - 1))
    return math.ceil((bins - 1) / (2.0 * pf_err) * (1.0 - a + math.sqrt(a) * pf_z) ** 3)


def temper(log_likelihood: Array, weights: Array, exponent: float, effective: float) -> Array:
    """Return new weights (n,): each weight times its likelihood to a power, normalized.

    The power is ``exponent``, or less if the effective sample size would fall below ``effective``.
    Otherwise a likelihood that is narrower than the distance between particles would leave a single
    particle, chosen by chance (annealed likelihood; Deutscher, Blake and Reid 2000).
    """
    return tempered(log_likelihood, weights, exponent, effective)


def regularize(
    poses: Array,
    clusters: Clusters,
    drawn: NDArray[np.int64],
    scale: float,
    rng: np.random.Generator,
) -> Array:
    """Return copies (m, 3) of particles, with noise that fills the gaps between particles.

    Without noise, resampling removes particles by chance. Along a direction that no scan measures,
    such as along a single wall, the cloud would shrink, and the filter would be sure of what it
    never measured. The noise has the cluster's covariance times h^2, with the bandwidth
    h = scale (4 / (n (d + 2)))^(1 / (d + 4)) and d = 3 (regularized particle filter; Musso, Oudjane
    and Le Gland 2001). The copies are first drawn toward the mean by sqrt(1 - h^2) (shrinkage;
    West 1993), and then corrected, so that the copies of a cluster keep its mean and covariance
    exactly. So the width stays right on average where no scan measures it. It still varies by
    chance: a start known to 20 mm along a wall was known to 3 to 30 mm after 8 s.

    Args:
        poses: (n, 3) weighed particles.
        clusters: their clusters.
        drawn: (m,) the particle that each is a copy of.
        scale: 1 is best for a normal distribution, 0 turns the noise off.
        rng: the only source of chance.
    """
    if scale == 0:
        return poses[drawn]
    means, covariances = clusters.means, clusters.covariances
    return spread_copies(poses, clusters.labels, means, covariances, drawn, scale, noise_key(rng))
