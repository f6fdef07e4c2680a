"""Resampling: how scans weigh particles, which go on, how many are needed, how copies spread.

And recovery: when to draw some from anywhere, the more the worse scans fit lately.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from robot.geometry import Array
from robot.localization.kernels.sampling import comb, noise_key, tempered
from robot.localization.kernels.spread_copies import spread_copies
from robot.localization.particles.clusters import Clusters


@dataclass
class Recovery:
    """Augmented MCL (Probabilistic Robotics, Table 8.3; nav2_amcl's recovery_alpha).

    Two running averages of how likely the scans are; where the fast one falls below the slow one,
    1 - fast / slow of the particles are replaced by random ones from anywhere.
    """

    slow: float = 0.0
    fast: float = 0.0

    def observe(
        self, log_likelihood: Array, weights: Array, rays: int, alpha_slow: float, alpha_fast: float
    ) -> None:
        """Take the average likelihood of a scan over particles with weights (n,) into account.

        It is that of one ray, the geometric mean over them: so scans with few rays and with many
        compare, and no single one outweighs all the others.

        Args:
            log_likelihood: (n,) of the whole scan.
            weights: (n,) from before it, summing to one.
            rays: how many the log-likelihood is the sum of.
            alpha_slow: share of the new value in the slow average; 0 is never to try elsewhere.
            alpha_fast: the same of the fast one.
        """
        if alpha_slow == 0 or alpha_fast == 0:
            return
        average = float(weights @ np.exp(log_likelihood / max(rays, 1)))
        self.slow += (alpha_slow if self.slow else 1.0) * (average - self.slow)
        self.fast += (alpha_fast if self.fast else 1.0) * (average - self.fast)

    def share(self) -> float:
        """Return the share of the particles to replace by random ones."""
        return max(0.0, 1.0 - self.fast / self.slow) if self.slow > 0 else 0.0


@njit(cache=True, nogil=True)
def coarseness(
    weights: Array, covariances: Array, particles: int, ranges: Array
) -> tuple[float, int]:
    """How far the particles of a cluster lie apart, as a spread of ranges [m].

    A likelihood narrower than that falls between them and none is right; so while the cloud is
    wide, ranges are believed that much less. Angles count as what they move the end of a typical
    ray by. Also how many rays returned; with none nothing can be said, and it is 0.

    Args:
        weights: (k,) share of the weight in each cluster.
        covariances: (k, 3, 3) of the clusters [m, m, rad].
        particles: how many there are in all.
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


@dataclass(frozen=True, slots=True)
class Resampled:
    """Which particles were drawn, as copies are in another order."""

    clusters: Clusters
    """Of the particles that were drawn from."""
    drawn: NDArray[np.int64]
    """(m,) as ``low_variance`` drew them."""
    renewed: NDArray[np.bool_]
    """(m,) which of the particles that go on come from anywhere instead."""
    in_order: bool
    """Whether the copies are in the order in which they were drawn: they are not, if spread."""

    @property
    def parents(self) -> NDArray[np.int64]:
        """Of which particle each that goes on is a copy (m,); -1 is of none."""
        parents = self.drawn
        if not self.in_order:
            # Copies of a cluster stand side by side; see ``spread_copies``.
            cluster = np.minimum(self.clusters.labels[parents], len(self.clusters.means))
            parents = parents[np.argsort(cluster, kind="stable")]
        return np.where(self.renewed, -1, parents)


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


def regularize(
    poses: Array,
    clusters: Clusters,
    drawn: NDArray[np.int64],
    scale: float,
    rng: np.random.Generator,
) -> Array:
    """Copies (m, 3) of particles, spread as wide as their cluster's particles are apart.

    Copies of few particles die out at random along a direction that the scans say nothing of, as
    along a single wall, and the filter would be sure of what it never measured. The noise has the
    cluster's covariance times the squared bandwidth h = scale (4 / (n (d + 2)))^(1 / (d + 4)) with
    d = 3 (regularized particle filter; Musso, Oudjane and Le Gland 2001). With it the copies are
    drawn together by sqrt(1 - h^2) (shrinkage; West 1993), and what chance still left of a
    difference is taken away: copies of a cluster have its mean and its covariance, neither more
    nor less. So the width is right on average wherever no scan holds it. It still wanders, as the
    weights are chance there, too: told to 20 mm along a wall, 3 to 30 mm were left after 8 s.

    Args:
        poses: (n, 3) weighed particles.
        clusters: those that they are in.
        drawn: (m,) which particle each is a copy of.
        scale: 1 is best for a normal distribution, 0 is none.
        rng: the only source of chance.
    """
    if scale == 0:
        return poses[drawn]
    means, covariances = clusters.means, clusters.covariances
    return spread_copies(poses, clusters.labels, means, covariances, drawn, scale, noise_key(rng))
