"""Sums over rays of a function of the distance at each ray's end, for the likelihood field.

Textbook twin: ``likelihood_field_range_finder_model`` of ``robot.localization.textbook``.

The work is done ray by ray, for 512 particles at a time, in three loops: find the word of the
table, read it, and add the function's value. The first and the last loop work on sixteen particles
at once. Reading has a loop of its own, because processors read scattered words one by one, and take
longer if asked for sixteen at once. All three take 0.8 ns for each ray and particle.
"""

from __future__ import annotations

import math

import numpy as np
from numba import float32, int32, uint32, uint64
from numpy.typing import NDArray

from robot.compiling import compiled
from robot.geometry import Array
from robot.localization.kernels.entry_planes import (
    DIRECTIONS,
    FARTHEST,
    STEEPEST,
    VALUE_SHIFT,
    X_SHIFT,
)
from robot.localization.kernels.steps import heading_vector

Row = NDArray[np.float32]
Words = NDArray[np.uint32]
Curve = tuple[np.float32, ...]

DEGREE = 8
"""Degree of the polynomial."""
BLOCK = 512
"""Particles in a block: its arrays fit the first-level cache of 32 kB."""
LANES = 16
"""Arrays of particles are padded to a multiple of this, what a processor works on at once."""
ROUND = 2.0**32
"""A full turn as a 32-bit number: sums of angles wrap around by themselves."""
FACING_SHIFT = 32 - int(math.log2(DIRECTIONS))
"""Shifts such an angle so that its highest bits, which number the table's direction, remain."""


@compiled()
def ray_ends(
    bearings: Array,
    ranges: Array,
    robot_from_scan: tuple[float, float, float],
    most: int,
    spread: tuple[float, float, float],
) -> NDArray[np.float32]:
    """Return rays that returned, at most ``most``, evenly spread, in the robot frame.

    (4, k): ends x, y [m], direction [rad], and 1 / (s^2 (1 + slope r^2)^2 + extra^2) [1 / m^2] of
    their ranges r; ``spread`` is s, slope and extra.
    """
    result = np.flatnonzero(np.isfinite(ranges))
    used = min(len(result), most)
    rays = np.empty((4, used), dtype=np.float32)
    x, y, theta = robot_from_scan
    sd, slope, extra = spread
    step = (len(result) - 1) / max(used - 1, 1)
    for j in range(used):
        ray = result[int(j * step)]
        direction = theta + bearings[ray]
        rays[0, j] = x + ranges[ray] * math.cos(direction)
        rays[1, j] = y + ranges[ray] * math.sin(direction)
        rays[2, j] = direction
        wide = sd * (1 + slope * ranges[ray] * ranges[ray])
        rays[3, j] = 1 / (wide * wide + extra * extra)
    return rays


@compiled()
def sum_over_rays(
    poses: Array,
    bearings: Array,
    ranges: Array,
    robot_from_scan: tuple[float, float, float],
    max_beams: int,
    planes: NDArray[np.int32],
    origin: tuple[float, float],
    resolution: float,
    max_distance: float,
    spread: tuple[float, float, float],
    end: float,
    curve: NDArray[np.float32],
) -> Array:
    """Return for poses (n, 3) the sums (n,) over rays of p(min(d^2 / (end sigma^2) - 1, 1)).

    d is the distance at the ray's end, and p a polynomial. Of the rays that returned, at most
    ``max_beams`` count, evenly spread.

    Args:
        poses: [m, m, rad] in the map.
        bearings: (r,) [rad] of the scan.
        ranges: (r,) [m], +inf where nothing returned.
        robot_from_scan: where the rays start, x, y, theta [m, m, rad].
        max_beams: how many rays count at most.
        planes: (directions, h, w) words of a table of distances d; see ``entry_planes``. It has
            DIRECTIONS tables, or one for all directions.
        origin: the map's x, y [m] at the table's corner.
        resolution: side of the table's cells [m].
        max_distance: the greatest distance in the table [m].
        spread: standard deviation of a near range [m], how it grows with a range's square
            [1 / m^2], and what is added to it [m]: sigma^2 = s^2 (1 + slope r^2)^2 + extra^2.
        end: scales d^2 / sigma^2 to the argument of p; from twice this value on, p is constant.
        curve: (9,) coefficients of p, lowest first.
    """
    rays = ray_ends(bearings, ranges, robot_from_scan, max_beams, spread)
    directions, height, width = planes.shape
    table = planes.ravel().view(np.uint32)
    last = uint32(directions - 1), uint32(height - 1), uint32(width - 1)
    # Distances are in steps of the word's value; ``unit`` makes their squares arguments of p.
    slope = float32(resolution / STEEPEST * FARTHEST / max_distance / 2 ** (32 - 2 * X_SHIFT - 9))
    unit = float32(1 / end * (max_distance / FARTHEST / 2**VALUE_SHIFT) ** 2)
    p = curve[1], curve[2], curve[3], curve[4], curve[5], curve[6], curve[7], curve[8]
    (x, y, cosines, sines), headings = _in_cells(poses, origin, 1.0 / resolution)
    sums = np.zeros(len(headings), dtype=np.float32)
    most = min(BLOCK, len(sums))
    cells, words = np.empty(most, dtype=np.uint32), np.empty(most, dtype=np.uint32)
    beside = rows(2, most)
    for start in range(0, len(sums), BLOCK):
        end = min(start + BLOCK, len(sums))
        size = end - start
        cell, word, u, v = cells[:size], words[:size], beside[0, :size], beside[1, :size]
        place = x[start:end], y[start:end], cosines[start:end], sines[start:end]
        heading, total = headings[start:end], sums[start:end]
        cell_pairs, word_pairs = cell.view(np.uint64), word.view(np.uint64)
        for j in range(rays.shape[1]):
            _find_cells(place, heading, (rays[0, j], rays[1, j], rays[2, j]), last, cell, u, v)
            _read(table, cell_pairs, word_pairs)
            _add_curve(word, u, v, slope, unit * rays[3, j], p, total)
    result: Array = sums[: len(poses)] + float(curve[0]) * rays.shape[1]
    return result


@compiled()
def rows(count: int, length: int) -> NDArray[np.float32]:
    """Return an uninitialized array (count, length) that begins at the start of a cache line."""
    room = np.empty(count * length + LANES, dtype=np.float32)
    skip = (-room.ctypes.data // 4) % LANES
    return room[skip : skip + count * length].reshape(count, length)


@compiled(fastmath=True, error_model="numpy")
def _in_cells(
    poses: Array, origin: tuple[float, float], scale: float
) -> tuple[tuple[Row, Row, Row, Row], NDArray[np.int32]]:
    """Return x, y, cosine and sine (m,) in cells of the table, and headings (m,) in parts of ROUND.

    The arrays are padded with zeros to a multiple of LANES.
    """
    count = (len(poses) + LANES - 1) // LANES * LANES
    places, headings = rows(4, count), np.zeros(count, dtype=np.int32)
    places[:, len(poses) :] = 0.0
    x, y, cosines, sines = places[0], places[1], places[2], places[3]
    theta = poses[:, 2].copy()
    for i in range(len(poses)):
        x[i], y[i] = (poses[i, 0] - origin[0]) * scale, (poses[i, 1] - origin[1]) * scale
    for i in range(len(poses)):
        cosine, sine = heading_vector(theta[i])
        cosines[i], sines[i] = cosine * scale, sine * scale
    for i in range(len(poses)):
        headings[i] = _parts(theta[i])
    return (x, y, cosines, sines), headings


@compiled(fastmath=True, error_model="numpy", forceinline=True)
def _parts(angle: float) -> np.int32:
    """Return an angle [rad] in parts of ROUND, between -1/2 and 1/2 of a turn."""
    turns = angle / (2 * math.pi)
    return np.int32((turns - math.floor(turns + 0.5)) * (ROUND - 1))


@compiled(fastmath=True, error_model="numpy")
def _find_cells(
    places: tuple[Row, Row, Row, Row],
    headings: NDArray[np.int32],
    ray: tuple[np.float32, np.float32, np.float32],
    last: tuple[np.uint32, np.uint32, np.uint32],
    cells: Words,
    along_x: Row,
    along_y: Row,
) -> None:
    """Find for each particle the cell in which a ray ends, and the place in that cell.

    An end outside the table is taken as in its last row or column, which is far from all edges.
    """
    x, y, cosines, sines = places
    ahead, aside, direction = ray
    last_facing, last_row, last_column = last
    # Half a direction more, so that the shift rounds to the nearest one.
    turn = uint32(_parts(float(direction))) + uint32(1 << (FACING_SHIFT - 1))
    for i in range(len(cells)):
        u = x[i] + cosines[i] * ahead - sines[i] * aside
        v = y[i] + sines[i] * ahead + cosines[i] * aside
        # Without a sign, a negative number is a very large one.
        column = min(np.uint32(np.int32(u)), last_column)
        row = min(np.uint32(np.int32(v)), last_row)
        facing = uint32(uint32(uint32(headings[i]) + turn) >> uint32(FACING_SHIFT))
        facing = uint32(facing & last_facing)
        cell = uint32(facing * (last_row + uint32(1)) + row)
        cells[i] = uint32(cell * (last_column + uint32(1)) + column)
        along_x[i] = u - float32(int32(column))
        along_y[i] = v - float32(int32(row))


@compiled()
def _read(table: Words, cell_pairs: NDArray[np.uint64], word_pairs: NDArray[np.uint64]) -> None:
    """Read words of the table; write them in pairs, as processors write more slowly than they
    read."""
    for i in range(len(cell_pairs)):
        pair = cell_pairs[i]
        second = uint64(table[pair >> uint64(32)])
        word_pairs[i] = uint64(table[uint32(pair)]) | (second << uint64(32))


@compiled(fastmath=True, error_model="numpy")
def _add_curve(
    words: Words,
    along_x: Row,
    along_y: Row,
    slope: np.float32,
    unit: np.float32,
    p: Curve,
    sums: Row,
) -> None:
    """Add p without its constant, at the distances that words and places in their cells give."""
    p1, p2, p3, p4, p5, p6, p7, p8 = p
    for i in range(len(words)):
        word = int32(words[i])
        change_x = float32(int32(word << int32(14))) * along_x[i]
        change_y = float32(int32(word << int32(23))) * along_y[i]
        d = float32(word) + (change_x + change_y) * slope
        t = min(d * d * unit - float32(1.0), float32(1.0))
        sums[i] += t * (
            p1 + t * (p2 + t * (p3 + t * (p4 + t * (p5 + t * (p6 + t * (p7 + t * p8))))))
        )
