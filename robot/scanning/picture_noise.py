"""Compiled measures of a picture's noise and clearness, and the edge search that suits them."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from robot.compiling import compiled
from robot.geometry import Array

CERTAIN = 3.5
"""An edge stands out of the noise by this many of the noise's standard deviations. Half: 18 % of
straight and of bent tape is missed instead of 1.8 and 2.5; twice: 2.1 and 2.9
(``python -m benchmarks.constants``)."""
GRAINY = 1.25
"""A floor has grain if the kernel's responses are so many times what the noise would make them: on
bare floors they are 0.9 to 1.22 times that, on wood, lino and concrete 1.1 to 2.3, on carpet 1.5 to
3.1 (40 pictures each on two fields). Half: pictures of bare floors count as grainy, too, and change
a little; twice: on light carpet 88 % of the rays to tape return, not 97 %; without, 13 %."""
_EVERY = 16
"""One in this many samples is used to measure the noise."""
CONTRAST = 0.83
"""How much darker tape is than the floor, as a share of the floor's brightness."""
LIGHT_CONTRAST = 1 / (1 - CONTRAST) - 1
"""The same for light tape: how much brighter it is than a floor as dark as tape."""
EVEN_CHANCE, CHANCE_SD = 1.2, 0.8
"""How far above the threshold an edge must stand for half of the rays to return it, and the spread
of this margin, in standard deviations of the kernel's response. Straightness and width, which are
judged too, are included. Measured on simulated pictures at a noise of 3 to 40 and a light of 1 to
0.15."""


@compiled()
def noise_of(grey: NDArray[np.int16], counts: NDArray[np.int32], apart: int) -> float:
    """Return the standard deviation of the picture's noise [grey levels].

    It is computed from the median second difference along the rays. A slope has no second
    difference, and edges are too few to move the median. For normal noise, the second difference
    has sqrt(6) times its standard deviation, and the median size is 0.6745 of that.

    ``apart`` is the number of samples to the next one that shares no pixel with the first.
    """
    return _median_size(grey, counts, apart, apart) / (0.6745 * math.sqrt(6.0))


@compiled()
def grain_of(
    responses: NDArray[np.int16], counts: NDArray[np.int32], half: int, apart: int
) -> float:
    """Return the standard deviation of noise that would make the kernel's responses [grey levels].

    Grain of the floor, as of carpet, is coarser than a pixel: the median second difference does not
    see all of it, but the edge kernel does, whose ``responses`` (k, m) are as of ``differences``.
    Samples that share pixels, as ``apart`` says, count as one.
    """
    return _median_size(responses, counts, half + 1, 0) / (0.6745 * math.sqrt(2.0 * half * apart))


@compiled()
def _median_size(
    values: NDArray[np.int16], counts: NDArray[np.int32], margin: int, bend: int
) -> float:
    """Return the median size of some values (k, m), or of second differences over ``bend``."""
    tally = np.zeros(1024, dtype=np.int32)
    total = below = size = 0
    for ray in range(len(counts)):
        for i in range(margin, counts[ray] - margin, _EVERY):
            value = values[ray, i]
            value = values[ray, i - bend] - 2 * value + values[ray, i + bend] if bend else value
            tally[min(abs(value), len(tally) - 1)] += 1
            total += 1
    while size < len(tally) - 1 and 2 * (below + tally[size]) < total:
        below += tally[size]
        size += 1
    return size - 0.5 + (0.5 * total - below) / tally[size] if size else 0.0


@compiled()
def kernel_for(noise: float, kernel: int, threshold: float) -> tuple[int, float]:
    """Return the edge kernel's half width and the threshold for a picture's noise [grey levels].

    Between the means of h samples ahead and behind, noise alone makes a difference of
    sqrt(2 / h) times its size. In noise, the kernel grows first, but only by up to half, so that
    the edges of far tape do not merge. Then the threshold grows.
    """
    wanted = math.ceil(2 * (CERTAIN * noise / threshold) ** 2)
    half = min(max(kernel, wanted), kernel + (kernel + 1) // 2)
    return half, max(threshold, CERTAIN * noise * math.sqrt(2 / half))


@compiled()
def clearness(
    grey: NDArray[np.int16],
    counts: NDArray[np.int32],
    noise: float,
    half: int,
    threshold: float,
    contrast: float = CONTRAST,
) -> Array:
    """Return the probability (k,) that tape on a ray is found, by the ray's own brightness.

    Args:
        grey: (k, m) grey levels along the rays.
        counts: (k,) samples in use.
        noise: standard deviation of a grey level.
        half: half width of the edge kernel [samples].
        threshold: weakest edge that counts [grey levels].
        contrast: how far the tape's brightness is from the floor's, as a share of the floor's.
    """
    sd = max(noise, 1.0) * math.sqrt(2 / half)
    clear = np.zeros(len(counts))
    for ray in range(len(counts)):
        if counts[ray] == 0:
            continue
        total = 0
        for i in range(counts[ray]):
            total += grey[ray, i]
        margin = (contrast * total / counts[ray] - threshold) / sd
        away = (margin - EVEN_CHANCE) / CHANCE_SD
        clear[ray] = 0.5 * (1 + math.erf(away / math.sqrt(2.0)))
    return clear
