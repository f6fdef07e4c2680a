"""Compiled search for edges along rays: where the floor gets darker, and where brighter again.

For light tape it is the other way round, and the same search on the negative of the responses.

A ray is first searched coarsely, at the pixels next to its samples. Only around a likely edge is
the picture interpolated, to find the edge's position between the pixels.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from robot.compiling import compiled
from robot.geometry import Array
from robot.scanning.picture_noise import (
    CONTRAST,
    GRAINY,
    LIGHT_CONTRAST,
    clearness,
    grain_of,
    kernel_for,
    noise_of,
)

PAIRS = 4
"""Largest number of pairs on one ray; farther pairs are left out."""
PARTS = 2
"""The step between samples is cut into this many parts to find an edge's position."""
REACH = 4
"""The position is searched in this many parts to either side."""
_NEAR = 2
"""The parabola through the maximum of the kernel's response uses the responses this many parts to
either side."""
SLANTED = 8.0
"""If a ray crosses an edge at a slant, the search is stretched by at most this factor. Half and
twice: no range changes (``python -m benchmarks.constants``)."""


@compiled()
def find_edges(
    picture: NDArray[np.uint8],
    pixel_indices: NDArray[np.uint32],
    counts: NDArray[np.int32],
    pixels: NDArray[np.float32],
    apart: int,
    kernel: int,
    threshold: float,
    light: bool = False,
) -> tuple[Array, NDArray[np.int32], Array, float, int, Array]:
    """Find entries and exits of dark stripes on each ray, between the pixels.

    Args:
        picture: (h, w)
        pixel_indices: (k, m) pixel of each sample, counted row by row.
        counts: (k,) samples in use on each ray.
        pixels: (k, m, 2) positions of the samples in the picture.
        apart: number of samples to the next one that shares no pixel with the first.
        kernel: half width of the edge kernel in a picture without much noise [samples].
        threshold: weakest edge that counts in such a picture [grey levels].
        light: whether light stripes are searched instead of dark ones.

    Returns:
        Pairs (k, PAIRS, 2) of entry and exit [samples], nan without one; the number of
        edges met (k,), where an odd number means that the last entry has no exit, and -1 that the
        ray is out of sight; the first exit without an entry before it, and the last entry without
        an exit after it (k, 2) [samples], nan without; the picture's noise [grey levels]; the half
        width of the kernel chosen for the noise [samples]; the probability (k,) that tape on a ray
        is found.
    """
    grey = sample_rays(picture, pixel_indices, counts)
    noise = noise_of(grey, counts, apart)
    half, weakest = kernel_for(noise, kernel, threshold)
    responses = differences(grey, counts, half)
    grain = grain_of(responses, counts, half, apart)
    if grain > GRAINY * max(noise, 1.0):
        noise = grain
        half, weakest = kernel_for(noise, kernel, threshold)
        responses = differences(grey, counts, half)
    if light:
        responses = -responses
    edges = np.full((len(counts), PAIRS, 2), np.nan)
    met = np.zeros(len(counts), dtype=np.int32)
    pairs = np.zeros((PAIRS, 2, 2), dtype=np.int32)
    single = np.full((len(counts), 2), np.nan)
    flat, width = picture.ravel(), picture.shape[1]
    for ray in range(len(counts)):
        if counts[ray] == 0:
            met[ray] = -1
            continue
        met[ray] = find_pairs(responses[ray, : counts[ray]], half, weakest, pairs, single[ray])
        for pair in range(met[ray] // 2):
            for side in range(2):
                sample, length = pairs[pair, side, 0], pairs[pair, side, 1]
                room = (min(sample, counts[ray] - 1 - sample) + 1) / (kernel + REACH / PARTS)
                scale = max(1.0, min(room, length / _sharp(half), SLANTED))
                edges[ray, pair, side] = refine(flat, width, pixels[ray], sample, kernel, scale)
    return (
        edges,
        met,
        single,
        noise,
        half,
        clearness(grey, counts, noise, half, weakest, LIGHT_CONTRAST if light else CONTRAST),
    )


@compiled()
def sample_rays(
    picture: NDArray[np.uint8], pixel_indices: NDArray[np.uint32], counts: NDArray[np.int32]
) -> NDArray[np.int16]:
    """Return the grey levels (k, m) of the pixels next to each sample.

    Only the first ``counts`` (k,) levels of a ray are filled in. ``pixel_indices`` (k, m) are
    counted row by row.
    """
    pixels = picture.ravel()
    grey = np.empty(pixel_indices.shape, dtype=np.int16)
    for ray in range(len(counts)):
        for i in range(counts[ray]):
            grey[ray, i] = pixels[pixel_indices[ray, i]]
    return grey


@compiled()
def differences(grey: NDArray[np.int16], counts: NDArray[np.int32], half: int) -> NDArray[np.int16]:
    """Return (k, m) the sum of ``half`` samples ahead minus those behind; 0 near a ray's ends."""
    responses = np.zeros(grey.shape, dtype=np.int16)
    start = half + 1
    for ray in range(len(counts)):
        size = counts[ray] - 2 * start
        if size <= 0:
            continue
        inner = responses[ray, start : start + size]
        for away in range(1, half + 1):
            ahead = grey[ray, start + away : start + away + size]
            behind = grey[ray, start - away : start - away + size]
            # The conversion lets the compiler process 32 samples at once.
            for i in range(size):
                inner[i] += np.int16(ahead[i] - behind[i])
    return responses


@compiled()
def find_pairs(
    response: NDArray[np.int16],
    half: int,
    threshold: float,
    pairs: NDArray[np.int32],
    single: Array,
) -> int:
    """Find entries and exits of dark stripes along one ray, to the nearest sample.

    An edge is a run of samples where the kernel's response is beyond the threshold. Of several
    entries in a row, the sharpest is kept. It forms a pair with the first exit after it.

    Args:
        response: (m,) row of ``differences`` of the ray.
        half: half width of the kernel [samples].
        threshold: weakest edge that counts [grey levels].
        pairs: (PAIRS, 2, 2) output: position and length of entry and exit [samples].
        single: (2,) output: position of the last exit before the first entry, as a ray may begin in
            something dark, and of the last entry if it has no exit [samples]; nan without.

    Returns:
        Number of edges met; an odd number means that the last entry has no exit.
    """
    weakest = math.ceil(threshold * half)
    result = sharpest = stop = 0
    single[:] = np.nan
    for i in range(len(response)):
        # Most samples are not on an edge, and need no more than this test.
        if abs(response[i]) < weakest or i < stop:
            continue
        stop = _run_end(response, i, weakest)
        peak, sample = _top(response, i, stop, half)
        if peak < sharpest:
            sharpest = peak
            pairs[result, 0, 0], pairs[result, 0, 1] = sample, stop - i
        elif peak > 0 and sharpest < 0:
            sharpest = 0
            pairs[result, 1, 0], pairs[result, 1, 1] = sample, stop - i
            result += 1
            if result == PAIRS:
                break
        elif peak > 0 and result == 0:
            single[0] = sample
    if sharpest < 0:
        single[1] = pairs[result, 0, 0]
    return 2 * result + (sharpest < 0)


@compiled()
def _run_end(response: NDArray[np.int16], start: int, weakest: int) -> int:
    """Return the first sample after ``start`` that is below the threshold or has the other sign."""
    darker = response[start] < 0
    for i in range(start + 1, len(response)):
        if abs(response[i]) < weakest or (response[i] < 0) != darker:
            return i
    return len(response)


@compiled()
def _top(response: NDArray[np.int16], start: int, stop: int, half: int) -> tuple[int, int]:
    """Return the strongest response of a run, and the position of its edge.

    The edge is where the response is strongest. In a run longer than that of a sharp edge, it is
    the run's centroid, because noise can put the top of a wide hill anywhere.
    """
    peak = sample = total = moment = 0
    for i in range(start, stop):
        size = abs(response[i])
        if size > abs(peak):
            peak, sample = response[i], i
        total += size
        moment += size * (i - start)
    if stop - start > _sharp(half):
        sample = start + (2 * moment + total) // (2 * total)
    return peak, sample


@compiled(inline="always")
def _sharp(half: int) -> int:
    """Return the longest run [samples] of a sharp edge that the ray crosses at a right angle."""
    return 2 * half + 2


@compiled()
def refine(
    picture: NDArray[np.uint8],
    width: int,
    pixels: NDArray[np.float32],
    sample: int,
    half: int,
    scale: float,
) -> float:
    """Return the position of an edge along a ray, in samples with fractions.

    The position is the maximum of the parabola through the same kernel's responses in finer steps,
    on the picture interpolated between four pixels. It is the sample itself where this straight
    search would leave the picture, because the lens may bend the ray away from a straight line.

    Args:
        picture: (h * w,) all pixels, row by row, ``width`` in a row.
        pixels: (m, 2) positions of the ray's samples in the picture.
        sample: the one where the edge was found.
        half: half width of the kernel [samples].
        scale: how many times wider than the kernel the edge is; the search is stretched by it.
    """
    wide, ends = half * PARTS, half * PARTS + REACH
    total = np.zeros(2 * ends + 2)
    u, v = float(pixels[sample, 0]), float(pixels[sample, 1])
    du = (pixels[sample + 1, 0] - pixels[sample - 1, 0]) * (scale / (2 * PARTS))
    dv = (pixels[sample + 1, 1] - pixels[sample - 1, 1]) * (scale / (2 * PARTS))
    far_u, far_v = ends * abs(du), ends * abs(dv)
    height = len(picture) // width
    if not (far_u <= u < width - 1 - far_u and far_v <= v < height - 1 - far_v):
        return float(sample)
    for j in range(2 * ends + 1):
        u_j, v_j = u + (j - ends) * du, v + (j - ends) * dv
        total[j + 1] = total[j] + _between(picture, width, u_j, v_j)
    best, top = 0, -1.0
    for j in range(_NEAR - REACH, REACH - _NEAR + 1):
        size = _response(total, wide, j)
        if size > top:
            best, top = j, size
    before, after = _response(total, wide, best - _NEAR), _response(total, wide, best + _NEAR)
    bend = before - 2 * top + after
    shift = 0.5 * _NEAR * (before - after) / bend if bend < 0 else 0.0
    return float(sample + scale * (best + shift) / PARTS)


@compiled(inline="always")
def _response(total: Array, wide: int, shift: int) -> float:
    """Return the size of the difference between the sums ahead and behind, from running totals."""
    position = wide + REACH + shift
    ahead, behind = (
        total[position + wide + 1] - total[position + 1],
        total[position] - total[position - wide],
    )
    return float(abs(ahead - behind))


@compiled(inline="always")
def _between(pixels: NDArray[np.uint8], width: int, u: float, v: float) -> float:
    """Return the brightness of a point between four pixels."""
    column, row = int(u), int(v)
    right, down = u - column, v - row
    # Unsigned indices need no check for indices that count from the end.
    position = np.uint32(row * width + column)
    a, b = np.float64(pixels[position]), np.float64(pixels[position + np.uint32(1)])
    position = np.uint32(position + width)
    c, d = np.float64(pixels[position]), np.float64(pixels[position + np.uint32(1)])
    above, below = a + (b - a) * right, c + (d - c) * right
    return float(above + (below - above) * down)
