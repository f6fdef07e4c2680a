"""Compiled measures of how clear a picture is, and how it must be searched for edges therefore."""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from robot.geometry import Array

CERTAIN = 3.5
"""Standard deviations of noise by which an edge stands out of it."""
_EVERY = 16
"""Of the samples, one in so many is looked at to measure noise."""


CONTRAST = 0.83
"""How much darker than the floor tape is, as a share of the floor's brightness."""
EVEN_CHANCE, CHANCE_SD = 1.2, 0.8
"""By so many standard deviations of the kernel's answer must an edge stand above the threshold for
half of the rays to return it, and the spread of that: straightness and width are judged, too.
Measured on simulated pictures at a noise of 3 to 40 and a light of 1 to 0.15."""


@njit(cache=True, nogil=True)
def noise_of(grey: NDArray[np.int16], counts: NDArray[np.int32], apart: int) -> float:
    """Standard deviation of the picture's noise [grey levels], by the median second difference.

    A slope has none, and edges are too few to move the median. Of normal noise, a second
    difference has sqrt(6) the standard deviation, and a median size of 0.6745 of that.

    ``apart`` is from one sample to the next that shares no pixel with it.
    """
    tally = np.zeros(1024, dtype=np.int32)
    total = 0
    for ray in range(len(counts)):
        for i in range(apart, counts[ray] - apart, _EVERY):
            bend = grey[ray, i - apart] - 2 * grey[ray, i] + grey[ray, i + apart]
            tally[abs(bend)] += 1
            total += 1
    below = size = 0
    while size < len(tally) - 1 and 2 * (below + tally[size]) < total:
        below += tally[size]
        size += 1
    if size == 0:
        return 0.0
    median = size - 0.5 + (0.5 * total - below) / tally[size]
    return float(median / (0.6745 * math.sqrt(6.0)))


@njit(cache=True, nogil=True)
def kernel_for(noise: float, kernel: int, threshold: float) -> tuple[int, float]:
    """Half width of the edge kernel and threshold that suit a picture's noise [grey levels].

    Between the means of h samples ahead and behind, noise alone makes a difference of
    sqrt(2 / h) its size. The kernel grows by up to half, lest far tape's edges run into one
    another, then the threshold.
    """
    wanted = math.ceil(2 * (CERTAIN * noise / threshold) ** 2)
    half = min(max(kernel, wanted), kernel + (kernel + 1) // 2)
    return half, max(threshold, CERTAIN * noise * math.sqrt(2 / half))


@njit(cache=True, nogil=True)
def clearness(
    grey: NDArray[np.int16], counts: NDArray[np.int32], noise: float, half: int, threshold: float
) -> Array:
    """Probability (k,) that tape in the way of a ray is found, by the ray's own brightness.

    Args:
        grey: (k, m) levels along the rays.
        counts: (k,) samples in use.
        noise: standard deviation of a level.
        half: half width of the edge kernel [samples].
        threshold: weakest edge that is one [grey levels].
    """
    sd = max(noise, 1.0) * math.sqrt(2 / half)
    clear = np.zeros(len(counts))
    for ray in range(len(counts)):
        if counts[ray] == 0:
            continue
        total = 0
        for i in range(counts[ray]):
            total += grey[ray, i]
        margin = (CONTRAST * total / counts[ray] - threshold) / sd
        away = (margin - EVEN_CHANCE) / CHANCE_SD
        clear[ray] = 0.5 * (1 + math.erf(away / math.sqrt(2.0)))
    return clear
