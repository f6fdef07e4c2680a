"""Resampling: which particles go on, and how many are needed."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numba import njit
from numpy.typing import NDArray

from robot.geometry import Array


def low_variance(weights: Array, count: int, rng: np.random.Generator) -> NDArray[np.int64]:
    """Indices (count,) of particles drawn by weight (Probabilistic Robotics, Table 4.4).

    One random number places an even comb over the weights (n,), which must sum to one; a particle
    of weight w is drawn floor(count w) or ceil(count w) times.
    """
    return _comb(weights, count, rng.random())


@njit(cache=True, nogil=True)
def _comb(weights: Array, count: int, start: float) -> NDArray[np.int64]:
    """One walk along the weights: 3 ns a particle, where a search for each takes 33.

    How often a particle is drawn is random, and a processor that guesses wrong waits. So two
    copies are always written, and then as many kept as there are.
    """
    drawn = np.empty(count + 2, dtype=np.int64)
    per_weight = count / weights.sum()
    edge, tooth, last = 0.0, 0, 0
    for i in range(len(weights)):
        edge += weights[i]
        # Teeth of the comb that lie below the particle's upper edge.
        below = min(math.ceil(edge * per_weight - start), count)
        drawn[tooth] = drawn[tooth + 1] = i
        for more in range(tooth + 2, below):
            drawn[more] = i
        if below > tooth:
            last = i
        tooth = max(tooth, below)
    # Rounding may leave the last edge a little low.
    drawn[tooth:] = last
    return drawn[:count]


@njit(cache=True, nogil=True)
def count_cells(cells: NDArray[np.int64], drawn: NDArray[np.int64]) -> int:
    """How many different cells there are among those (n,) of the drawn particles."""
    seen = np.zeros(cells.max() + 1, dtype=np.bool_)
    for i in drawn:
        seen[cells[i]] = True
    return int(np.count_nonzero(seen))


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
    return _tempered(log_likelihood, weights, exponent, effective)


@njit(cache=True, nogil=True)
def _tempered(log_likelihood: Array, weights: Array, exponent: float, effective: float) -> Array:
    best = -np.inf
    for i in range(len(weights)):
        if weights[i] > 0 and log_likelihood[i] > best:
            best = log_likelihood[i]
    if best == -np.inf:
        return weights.copy()  # to something that is possible nowhere nothing is to be learnt from
    new = np.empty_like(weights)
    total, squares = _powers(log_likelihood, best, weights, exponent, new)
    if total * total < effective * squares:
        low, high = 0.0, exponent
        for _ in range(12):
            middle = (low + high) / 2
            total, squares = _powers(log_likelihood, best, weights, middle, new)
            if total * total >= effective * squares:
                low = middle
            else:
                high = middle
        total, _ = _powers(log_likelihood, best, weights, low, new)
    new /= total
    return new


@njit(cache=True, nogil=True, fastmath={"reassoc", "contract", "nsz"}, error_model="numpy")
def _powers(
    log_likelihood: Array, best: float, weights: Array, power: float, new: Array
) -> tuple[float, float]:
    """Fill ``new`` with weights times likelihoods to a power; their sum, and that of squares."""
    total = squares = 0.0
    for i in range(len(weights)):
        # Above the best of those that still count nothing can be: there the product would overflow.
        product = weights[i] * _exponential(power * min(log_likelihood[i] - best, 0.0))
        new[i] = product
        total += product
        squares += product * product
    return total, squares


@njit(cache=True, nogil=True, fastmath={"contract"}, error_model="numpy", forceinline=True)
def _exponential(x: float) -> float:
    """exp(x) of x up to 80, to 1e-8; below -80 as there. Without a call, so that loops are quick.

    A power of two, by its bits, times a Taylor series.
    """
    cut = max(x, -80.0)
    power = math.floor(cut * (1 / math.log(2.0)) + 0.5)
    t = cut - power * math.log(2.0)
    series = 1 + t / 4 * (1 + t / 5 * (1 + t / 6 * (1 + t / 7 * (1 + t / 8))))
    series = 1 + t * (1 + t / 2 * (1 + t / 3 * series))
    two = np.int32((np.int32(power) + np.int32(127)) << np.int32(23)).view(np.float32)
    return float(two) * series
