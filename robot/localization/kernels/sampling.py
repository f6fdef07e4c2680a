"""Many normal random numbers at once, and loops over the weights of particles.

A filter needs six normal numbers for each particle and update. NumPy's generator makes them one
after the other, in 8 ns each. Here each number depends only on a key and on its index, so that the
compiler can work on sixteen at a time, in 0.5 ns each. NumPy's generator remains the only source of
randomness: it draws the key.

Textbook twin of ``comb``: ``low_variance_sampler`` of ``robot.localization.textbook``.
"""

from __future__ import annotations

import math

import numpy as np
from numba import float32, int32, uint32, uint64
from numpy.polynomial import Chebyshev, Polynomial
from numpy.typing import NDArray

from robot.compiling import compiled
from robot.geometry import Array


def _fit(values: Array, low: float, high: float, places: Array, degree: int) -> list[np.float32]:
    """Return the coefficients, lowest first, of a polynomial fitted to values from low to high."""
    fitted = Chebyshev.fit(places, values, degree, [low, high]).convert(kind=Polynomial)
    return [np.float32(coefficient) for coefficient in fitted.coef]


_MANTISSA = np.linspace(1.0, 2.0, 500)
_SQUARE = np.linspace(1e-9, 0.25, 500)
_LOG = _fit(np.log(_MANTISSA), 1.0, 2.0, _MANTISSA, 7)
"""log of numbers from 1 to 2; the error is below 4e-7."""
_SINE = _fit(np.sin(2 * np.pi * np.sqrt(_SQUARE)) / np.sqrt(_SQUARE), 0.0, 0.25, _SQUARE, 5)
"""sin(2 pi t) / t as a polynomial in t^2, for t from -1/2 to 1/2; the error is below 1e-6."""
_COSINE = _fit(np.cos(2 * np.pi * np.sqrt(_SQUARE)), 0.0, 0.25, _SQUARE, 6)
"""cos(2 pi t) as a polynomial in t^2."""
L0, L1, L2, L3, L4, L5, L6, L7 = _LOG
S0, S1, S2, S3, S4, S5 = _SINE
C0, C1, C2, C3, C4, C5, C6 = _COSINE
_LOG_2 = np.float32(math.log(2.0))


def noise_key(rng: np.random.Generator) -> int:
    """Return a random key for ``normal_rows``: 63 bits, as compiled code takes signed numbers."""
    return rng.bit_generator.random_raw() >> 1


@compiled(fastmath=True, error_model="numpy")
def _fill(key: np.uint64, result: NDArray[np.float32]) -> None:
    """Fill an array with normal numbers by Box and Muller (1958).

    Pair i is made of 64 bits of SplitMix64 (Steele, Lea and Flood 2014), which mixes key and i: one
    half gives the radius, the other the angle.
    """
    half = len(result) // 2
    first, second = result[:half], result[half:]
    for i in range(half):
        z = uint64(key) + uint64(i) * uint64(0x9E3779B97F4A7C15)
        z = (z ^ (z >> uint64(30))) * uint64(0xBF58476D1CE4E5B9)
        z = (z ^ (z >> uint64(27))) * uint64(0x94D049BB133111EB)
        z = z ^ (z >> uint64(31))
        radius = _radius(uint32(z >> uint64(32)))
        part = float32(int32(uint32(z))) * float32(2.0**-32)  # of a turn, -1/2 to 1/2
        q = part * part
        sine = part * (S0 + q * (S1 + q * (S2 + q * (S3 + q * (S4 + q * S5)))))
        cosine = C0 + q * (C1 + q * (C2 + q * (C3 + q * (C4 + q * (C5 + q * C6)))))
        first[i] = radius * cosine
        second[i] = radius * sine


@compiled(fastmath=True, error_model="numpy", forceinline=True)
def _radius(word: np.uint32) -> np.float32:
    """Return sqrt(-2 log u) for u = (word + 1/2) / 2^32; the log is by exponent and mantissa."""
    number = np.float32(float32(word) + float32(0.5))
    bits = np.float32(number).view(np.int32)
    exponent = float32((bits >> int32(23)) - int32(127 + 32))
    m = np.int32((bits & int32(0x7FFFFF)) | int32(0x3F800000)).view(np.float32)
    log = L0 + m * (L1 + m * (L2 + m * (L3 + m * (L4 + m * (L5 + m * (L6 + m * L7))))))
    # By rounding, the logarithm of a number near one can be a little above zero.
    minus = float32(-2.0) * (log + exponent * _LOG_2)
    return float32(math.sqrt(max(minus, float32(0.0))))


@compiled()
def normal_rows(key: int, rows: int, count: int) -> NDArray[np.float32]:
    """Return independent standard normal numbers (rows, count or one more)."""
    noise = np.empty((rows, count + count % 2), dtype=np.float32)
    _fill(np.uint64(key), noise.reshape(-1))
    return noise


@compiled()
def comb(weights: Array, count: int, start: float) -> NDArray[np.int64]:
    """Return the indices (count,) of the drawn particles, in one walk along the weights.

    It takes 3 ns a particle; a binary search for each takes 33. How often a particle is drawn is
    random, and a branch on it is predicted wrongly too often. So two copies are always written, and
    the next particle overwrites those that are too many.
    """
    drawn = np.empty(count + 2, dtype=np.int64)
    per_weight = count / weights.sum()
    edge, tooth, last = 0.0, 0, 0
    for i in range(len(weights)):
        edge += weights[i]
        # How many teeth of the comb lie below the particle's upper edge.
        below = min(math.ceil(edge * per_weight - start), count)
        drawn[tooth] = drawn[tooth + 1] = i
        for more in range(tooth + 2, below):
            drawn[more] = i
        if below > tooth:
            last = i
        tooth = max(tooth, below)
    # By rounding, the last edge can lie a little below the last tooth.
    drawn[tooth:] = last
    return drawn[:count]


@compiled()
def count_cells(cells: NDArray[np.int64], drawn: NDArray[np.int64]) -> int:
    """Return in how many different cells the drawn particles lie; ``cells`` (n,) are of all."""
    seen = np.zeros(cells.max() + 1, dtype=np.bool_)
    for i in drawn:
        seen[cells[i]] = True
    return int(np.count_nonzero(seen))


@compiled()
def tempered(log_likelihood: Array, weights: Array, exponent: float, effective: float) -> Array:
    """Return new weights (n,), as ``particles.resampling.temper`` explains."""
    best = -np.inf
    for i in range(len(weights)):
        if weights[i] > 0 and log_likelihood[i] > best:
            best = log_likelihood[i]
    if best == -np.inf:
        return weights.copy()  # no particle can explain the scan: it says nothing of the weights
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


@compiled(fastmath={"reassoc", "contract", "nsz"}, error_model="numpy")
def _powers(
    log_likelihood: Array, best: float, weights: Array, power: float, new: Array
) -> tuple[float, float]:
    """Fill ``new`` with weights times likelihoods to a power; return its sum and sum of squares."""
    total = squares = 0.0
    for i in range(len(weights)):
        # A particle without weight may fit better than the best with weight: exp would overflow.
        product = weights[i] * math.exp(power * min(log_likelihood[i] - best, 0.0))
        new[i] = product
        total += product
        squares += product * product
    return total, squares
