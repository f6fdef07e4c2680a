"""The compiled loops of the simulated camera: strips of pixels on one tone, and the others."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from robot.compiling import compiled
from robot.geometry import Array

STRIP = 8
"""Neighbouring pixels that are looked up together."""

TILE_ROWS, TILE_STRIPS = 8, 8
"""Rows and strips of a tile, which is looked up at once; strips are where it has several tones.
Half and twice: 0.26 and 0.23 ms a picture of *square*; with 8, 0.23 ms; without tiles 0.41."""

MARGIN_PX = 2.0
"""Interpolation looks one pixel further than the sample; rounding takes the other."""

BLOCK = 2
"""Side of the blocks of the drawing for which the way to the next edge is kept [px].
Half and twice: 1.51 and 1.78 ms a picture of *square*; with 2, 1.54 ms."""


@compiled()
def affines_at(times: Array, knots: Array, affines: Array) -> NDArray[np.float32]:
    """Interpolate affines (n, 2, 3) that are known at knots (n,), in order, at each time (s,)."""
    between = np.empty((len(times), 2, 3), dtype=np.float32)
    end, last = 1, len(knots) - 1
    for k in range(len(times)):
        while end < last and knots[end] < times[k]:
            end += 1
        while end > 1 and knots[end - 1] > times[k]:
            end -= 1
        span, since = knots[end] - knots[end - 1], times[k] - knots[end - 1]
        for row in range(2):
            for column in range(3):
                before, after = affines[end - 1, row, column], affines[end, row, column]
                slope = (after - before) / span if span > 0.0 else 0.0
                between[k, row, column] = slope * since + before
    return between


@compiled(fastmath=True)
def fill_even_strips(
    picture: NDArray[np.uint8],
    uneven: NDArray[np.int32],
    samples: NDArray[np.float32],
    points: NDArray[np.float32],
    centres: NDArray[np.float32],
    affines: NDArray[np.float32],
    firsts: NDArray[np.intp],
    counts: NDArray[np.intp],
    spread: Array,
    distance: Array,
    tiles: Array,
    blurred: tuple[float, float],
    tiles_blurred: tuple[float, float],
    resolution: float,
    even: NDArray[np.uint8],
    size: tuple[int, int],
    border: int,
) -> tuple[int, int]:
    """Fill the strips of pixels around which the floor has one tone; list the others.

    Args:
        picture: (h, w), gets the tones.
        uneven: gets row and first column of the other strips (2, n).
        samples: gets the places of their samples in the drawing, column and row (2, n) [px].
        points: the samples' floor points, x and y apart (2, s, w) [m].
        centres: the floor points of the strips' middles (h, strips, 2) [m].
        affines: (s, 2, 3), from the robot frame to the drawing, for each row of samples.
        firsts: the first row of samples of each row of pixels (h,).
        counts: the samples of each pixel (h,).
        spread: how far a strip's samples lie from its middle (h, strips) [m].
        distance: how far they lie from the robot (h, strips) [m].
        tiles: (tile rows, tiles, 4), of each tile as of strips: its middle's floor point, how far
            its samples lie from there, and from the robot [m].
        blurred: way [m] and turn [rad] of the robot in an exposure.
        tiles_blurred: the same, until all rows of a tile are exposed.
        resolution: a pixel of the drawing [m].
        even: how far all is of one tone around each block of the drawing [px], and that tone.
        size: height and width of the drawing [px].
        border: the tone outside it.

    Returns:
        The number of listed strips, and of their samples.
    """
    height, width = picture.shape
    tones = np.empty(tiles.shape[1], dtype=np.int64)
    strips = count = 0
    for row in range(height):
        first, last = firsts[row], firsts[row] + counts[row]
        middle = affines[first + counts[row] // 2]
        if row % TILE_ROWS == 0:
            _look_up_tiles(
                tones,
                tiles[row // TILE_ROWS],
                middle,
                tiles_blurred,
                resolution,
                even,
                size,
                border,
            )
        for tile in range(len(tones)):
            begin = tile * TILE_STRIPS * STRIP
            if tones[tile] >= 0:
                picture[row, begin : begin + TILE_STRIPS * STRIP] = tones[tile]
                continue
            for strip in range(begin // STRIP, min(begin // STRIP + TILE_STRIPS, spread.shape[1])):
                start, end = strip * STRIP, min(strip * STRIP + STRIP, width)
                moved = blurred[0] + blurred[1] * distance[row, strip]
                reach = (spread[row, strip] + moved) / resolution + MARGIN_PX
                x, y = centres[row, strip, 0], centres[row, strip, 1]
                u = middle[0, 0] * x + middle[0, 1] * y + middle[0, 2]
                v = middle[1, 0] * x + middle[1, 1] * y + middle[1, 2]
                tone = _tone(u, v, reach, even, size, border)
                if tone >= 0:
                    picture[row, start:end] = tone
                    continue
                uneven[0, strips], uneven[1, strips] = row, start
                strips += 1
                for sample in range(first, last):
                    a, b, c = affines[sample, 0, 0], affines[sample, 0, 1], affines[sample, 0, 2]
                    d, e, f = affines[sample, 1, 0], affines[sample, 1, 1], affines[sample, 1, 2]
                    for i in range(end - start):
                        x, y = points[0, sample, start + i], points[1, sample, start + i]
                        samples[0, count + i] = a * x + b * y + c
                        samples[1, count + i] = d * x + e * y + f
                    count += end - start
    return strips, count


@compiled(fastmath=True)
def _look_up_tiles(
    tones: NDArray[np.int64],
    tiles: Array,
    first: NDArray[np.float32],
    blurred: tuple[float, float],
    resolution: float,
    even: NDArray[np.uint8],
    size: tuple[int, int],
    border: int,
) -> None:
    """Write the tone of each tile (n,) of a row of tiles (n, 4), -1 where it has several.

    ``first`` is the affine of its first row of pixels.
    """
    for tile in range(len(tones)):
        x, y, spread, distance = tiles[tile]
        reach = (spread + blurred[0] + blurred[1] * distance) / resolution + MARGIN_PX
        u = first[0, 0] * x + first[0, 1] * y + first[0, 2]
        v = first[1, 0] * x + first[1, 1] * y + first[1, 2]
        tones[tile] = _tone(u, v, reach, even, size, border)


@compiled()
def _tone(
    u: float,
    v: float,
    reach: float,
    even: NDArray[np.uint8],
    size: tuple[int, int],
    border: int,
) -> int:
    """Return the tone of all that lies around a place of the drawing; -1 if it has several."""
    outside = max(-u, u - size[1], -v, v - size[0])
    if outside > reach:
        return border
    if outside > 0:
        return -1
    row, column = int(v) // BLOCK + 1, int(u) // BLOCK + 1
    return int(even[row, column, 1]) if even[row, column, 0] > reach else -1


@compiled()
def fill_uneven_strips(
    picture: NDArray[np.uint8],
    uneven: NDArray[np.int32],
    grey: NDArray[np.uint8],
    counts: NDArray[np.intp],
) -> None:
    """Fill each pixel of the listed strips (2, n) with the mean of its samples."""
    begin = 0
    for row, start in uneven.T:
        size = min(STRIP, picture.shape[1] - start)
        for column in range(size):
            total = 0
            for sample in range(counts[row]):
                total += grey[begin + sample * size + column]
            picture[row, start + column] = np.rint(total / counts[row])
        begin += counts[row] * size
