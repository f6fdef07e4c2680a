"""Loops over the weights of particles: resampling, and weighing by powers of likelihoods.

Textbook twin of ``comb``: ``low_variance_sampler`` of ``robot.localization.textbook``.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from robot.geometry import Array


@njit(cache=True, nogil=True)
def comb(weights: Array, count: int, start: float) -> NDArray[np.int64]:
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


@njit(cache=True, nogil=True)
def tempered(log_likelihood: Array, weights: Array, exponent: float, effective: float) -> Array:
    """Return new weights (n,), as ``particles.resampling.temper`` explains."""
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
        product = weights[i] * math.exp(power * min(log_likelihood[i] - best, 0.0))
        new[i] = product
        total += product
        squares += product * product
    return total, squares
