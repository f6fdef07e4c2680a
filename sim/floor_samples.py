"""Which grey each pixel of a camera gets from the drawing of the floor.

Each pixel sees one point of the floor, and the lens does not change. So the floor points of each
pixel, and of several samples inside it, are computed once in the robot frame; a picture is then one
look-up in the drawing of the floor. The samples of a pixel are spread over its height, because the
floor is seen at a slant and would alias, and over the exposure time, which gives motion blur. Rows
are exposed one after the other, as with a rolling shutter.

Most of a floor has one tone. A strip of pixels whose samples all lie on such a floor gets that tone
from one look-up; only the others are sampled. The result is the same to the last bit.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise

import cv2
import numpy as np
from numpy.typing import NDArray

from robot.camera import FloorView
from robot.fields.floor_picture import FloorPicture
from robot.fields.occupancy_grid import cell_distances
from robot.geometry import Array, Pose2, Twist2
from sim.floor_kernels import (
    BLOCK,
    STRIP,
    TILE_ROWS,
    TILE_STRIPS,
    affines_at,
    fill_even_strips,
    fill_uneven_strips,
)

SAMPLES = (4, 8)
"""Samples over the height of a pixel; rows whose pixels cover more floor use more."""

FOOTPRINT_M = 0.0015
"""Length of floor, along the view, that one sample should cover at most [m]."""

EXPOSURE_S = 0.0025
"""Part of an exposure that one sample should cover at most [s]: a fast robot moves by a millimetre
meanwhile. With fewer samples, blurred edges become steps, and each step an edge."""

MOST_SAMPLES = 32
"""Most samples of a pixel."""

_NEIGHBOURS = np.ones((3, 3), dtype=np.uint8)
_Lists = tuple[NDArray[np.int32], NDArray[np.float32]]
"""Room for the listed strips, and for the places of their samples."""


class FloorSamples:
    """Averages the drawing of one floor over each pixel of one camera."""

    def __init__(self, view: FloorView, floor: FloorPicture, exposure: float) -> None:
        """Prepare the samples of a camera with an exposure time [s]."""
        self._floor = floor
        self._exposures = exposure, exposure + TILE_ROWS * view.lens.readout / view.lens.height
        self._size = (view.lens.height, view.lens.width)
        self._seen = _spread_samples(view, exposure)
        self._even = _even_blocks(floor)
        self._pixel_from_map = np.vstack([floor.pixel_from_map, [0, 0, 1]])
        self._spare: list[_Lists] = []
        """Lists that no picture is being made with. A new one costs half a millisecond a picture:
        the system clears each page of its memory when it is first written."""

    def average(self, map_from_robot: Pose2, twist: Twist2) -> NDArray[np.uint8]:
        """Return the grey (h, w) that each pixel sees from a pose, while moving with a twist.

        The robot is at the pose in the middle of the exposure of the middle row.
        """
        seen = self._seen
        affines = _sample_affines(self._pixel_from_map, map_from_robot, twist, seen.times)
        v, omega = abs(twist.v), abs(twist.omega)
        blurred, tiles_blurred = ((time * v, time * omega) for time in self._exposures)
        picture = np.empty(self._size, dtype=np.uint8)
        uneven, samples = lists = self._lists()
        strips, count = fill_even_strips(
            picture, uneven, samples, seen.points, seen.centres, affines, seen.firsts,
            seen.counts, seen.spread, seen.distance, seen.tiles, blurred, tiles_blurred,
            self._floor.resolution, self._even, self._floor.image.shape, self._floor.border,
        )  # fmt: skip
        if strips > 0:
            grey = self._look_up(samples, count)
            fill_uneven_strips(picture, uneven[:, :strips], grey, seen.counts)
        self._spare.append(lists)
        return picture

    def _lists(self) -> _Lists:
        """Return room for what a picture may list; any thread may ask."""
        try:
            return self._spare.pop()
        except IndexError:
            return (
                np.empty((2, self._seen.spread.size), dtype=np.int32),
                np.empty((2, self._seen.points[0].size), dtype=np.float32),
            )

    def _look_up(self, samples: NDArray[np.float32], count: int) -> NDArray[np.uint8]:
        """Return the grey of the first samples, given by column and row (2, n) of the drawing."""
        # OpenCV takes rows of at most 32,767 px.
        width = self._size[1]
        height = -(-count // width)
        samples[:, count : height * width] = 0
        columns, rows = (part[: height * width].reshape(height, width) for part in samples)
        grey = cv2.remap(
            self._floor.image,
            columns,
            rows,
            cv2.INTER_LINEAR,
            borderMode=cv2.BORDER_CONSTANT,
            borderValue=self._floor.border,
        )
        return np.asarray(grey, dtype=np.uint8).ravel()


@dataclass(frozen=True, slots=True, eq=False)
class _Samples:
    """The samples of one camera, whatever floor it sees: s of them in each column, h rows."""

    points: NDArray[np.float32]
    """(2, s, w) x and y on the floor, in the robot frame [m]."""
    times: Array
    """(s,) from the picture's stamp [s]."""
    counts: NDArray[np.intp]
    """(h,) samples of a pixel of each row."""
    firsts: NDArray[np.intp]
    """(h,) which is the first of them."""
    centres: NDArray[np.float32]
    """(h, strips, 2) the middle of each strip [m]; to fetch it from all points takes long."""
    spread: Array
    """(h, strips) how far samples lie from there at most [m]."""
    distance: Array
    """(h, strips) how far they lie from the robot at most [m]."""
    tiles: Array
    """(tile rows, tiles, 4) the same of tiles: middle (2), and both distances [m]."""


@lru_cache(maxsize=2)
def _spread_samples(view: FloorView, exposure: float) -> _Samples:
    bands = _bands(view, exposure)
    points, times = _samples(view, bands, exposure)
    counts = np.array([band.samples for band in bands for _ in range(band.first, band.last)])
    firsts = np.cumsum(counts) - counts
    centres = _centres(points, firsts, counts)
    spread, distance = _extent(points, centres, firsts, counts)
    tiles = _tiles(centres, spread, distance)
    return _Samples(points, times, counts, firsts, centres, spread, distance, tiles)


@dataclass(frozen=True, slots=True)
class _Band:
    """Rows of the picture, from first to last (exclusive), with the same number of samples."""

    first: int
    last: int
    samples: int


def _bands(view: FloorView, exposure: float) -> list[_Band]:
    """Cut the picture into bands; rows whose pixels cover much floor use more samples.

    An exposure that takes long [s] needs as many in all rows.
    """
    height = view.lens.height
    middle = np.full(height + 1, (view.lens.width - 1) / 2)
    floor = view.floor_points(np.column_stack([middle, np.arange(height + 1) - 0.5]))
    footprint = np.linalg.norm(np.diff(floor, axis=0), axis=1)
    wanted = np.nan_to_num(footprint / FOOTPRINT_M, nan=np.inf)
    by_footprint = np.array(SAMPLES)[np.searchsorted(SAMPLES[:-1], wanted)]
    moments = max(1.0, exposure / EXPOSURE_S)
    samples = np.maximum(by_footprint, min(2 ** math.ceil(math.log2(moments)), MOST_SAMPLES))
    cuts = [0, *(np.flatnonzero(np.diff(samples)) + 1), height]
    return [_Band(a, b, int(samples[a])) for a, b in pairwise(cuts)]


def _samples(
    view: FloorView, bands: list[_Band], exposure: float
) -> tuple[NDArray[np.float32], Array]:
    """Return the samples' floor points (2, s, w) [m] and times (s,) [s].

    The points are in the robot frame; the times count from the picture's stamp.
    """
    lens = view.lens
    rows, times = [], []
    for band in bands:
        part = (np.arange(band.samples) + 0.5) / band.samples - 0.5
        row = np.arange(band.first, band.last)[:, None]
        rows.append((row + part).ravel())
        # Exposure times have another order than heights: otherwise both add up along a slant.
        shuffled = part[_bit_reversed(band.samples)]
        row_time = lens.readout * (row / (lens.height - 1) - 0.5)
        times.append((row_time + exposure * shuffled).ravel())
    v = np.concatenate(rows)
    points = np.empty((2, len(v), lens.width), dtype=np.float32)
    columns = np.arange(lens.width, dtype=np.float64)
    # In parts: on the way a point takes twenty times the memory that it takes at the end.
    for some in np.array_split(np.arange(len(v)), 64):
        pixels = np.stack(np.broadcast_arrays(columns, v[some, None]), axis=-1)
        floor = view.floor_points(pixels.reshape(-1, 2))
        # Above the horizon there is no floor: use a point so far away that it has the border's
        # tone.
        points[:, some] = np.nan_to_num(floor, nan=1e6).T.reshape(2, len(some), lens.width)
    return points, np.concatenate(times)


def _bit_reversed(count: int) -> list[int]:
    bits = count.bit_length() - 1
    return [int(f"{i:0{bits}b}"[::-1], 2) for i in range(count)]


def _sample_affines(
    pixel_from_map: Array, map_from_robot: Pose2, twist: Twist2, times: Array
) -> NDArray[np.float32]:
    """Return affines (s, 2, 3) from the robot frame at each time to pixels of the floor picture.

    ``pixel_from_map`` (3, 3) leads from the map to the picture.
    """
    # Between nine moments of a picture the motion is straight to well under a micrometre.
    knots = np.linspace(times.min(), times.max(), 9)
    moments = [map_from_robot @ twist.integrate(float(t)) for t in knots]
    affines = pixel_from_map[:2] @ np.array([_homogeneous(pose) for pose in moments])
    return affines_at(times, knots, affines)


def _homogeneous(pose: Pose2) -> list[list[float]]:
    """Return the matrix (3, 3) of a pose."""
    c, s = math.cos(pose.theta), math.sin(pose.theta)
    return [[c, -s, pose.x], [s, c, pose.y], [0.0, 0.0, 1.0]]


def _centres(
    points: NDArray[np.float32], firsts: NDArray[np.intp], counts: NDArray[np.intp]
) -> NDArray[np.float32]:
    """Return the floor point of each strip's middle (h, strips, 2) [m]."""
    width = points.shape[2]
    starts = np.arange(0, width, STRIP)
    columns = (starts + np.minimum(starts + STRIP, width)) // 2
    middles = points[:, firsts + counts // 2][..., columns]
    return np.ascontiguousarray(np.moveaxis(middles, 0, -1))


def _extent(
    points: NDArray[np.float32],
    centres: NDArray[np.float32],
    firsts: NDArray[np.intp],
    counts: NDArray[np.intp],
) -> tuple[Array, Array]:
    """Return how far the samples of each strip lie from its middle, and from the robot, at most.

    Both are (h, strips) [m].
    """
    width = points.shape[2]
    starts = np.arange(0, width, STRIP)
    spread, distance = np.empty((2, *centres.shape[:2]))
    for row, (first, count) in enumerate(zip(firsts, counts, strict=True)):
        samples = np.moveaxis(points[:, first : first + count], 0, -1)
        centre = np.repeat(centres[row], STRIP, axis=0)[:width]
        from_centre = np.linalg.norm(samples - centre, axis=-1).max(axis=0)
        spread[row] = np.maximum.reduceat(from_centre, starts)
        distance[row] = np.maximum.reduceat(np.linalg.norm(samples, axis=-1).max(axis=0), starts)
    return spread, distance


def _tiles(centres: NDArray[np.float32], spread: Array, distance: Array) -> Array:
    """Return what is known of each tile (tile rows, tiles, 4) from that of its strips."""
    rows, strips = (
        range(0, n, k) for n, k in zip(spread.shape, (TILE_ROWS, TILE_STRIPS), strict=True)
    )
    tiles = np.empty((len(rows), len(strips), 4))
    for i, j in np.ndindex(tiles.shape[:2]):
        part = np.s_[rows[i] : rows[i] + TILE_ROWS, strips[j] : strips[j] + TILE_STRIPS]
        inside = centres[part]
        middle = inside[inside.shape[0] // 2, inside.shape[1] // 2]
        from_middle = np.linalg.norm(inside - middle, axis=-1) + spread[part]
        tiles[i, j] = *middle, from_middle.max(), distance[part].max()
    return tiles


@lru_cache(maxsize=2)
def _even_blocks(floor: FloorPicture) -> NDArray[np.uint8]:
    """Return how far all is of one tone around each block of the drawing, and that tone.

    The result is (rows, columns, 2), in px, at most 255. The drawing has a block of its border's
    tone around it, as what lies outside has that tone.
    """
    height, width = floor.image.shape
    rest = [(BLOCK, BLOCK + -side % BLOCK) for side in (height, width)]
    padded = np.pad(floor.image, rest, constant_values=floor.border)
    uneven = cv2.dilate(padded, _NEIGHBOURS) != cv2.erode(padded, _NEIGHBOURS)
    blocks = uneven.reshape(len(padded) // BLOCK, BLOCK, -1, BLOCK).any(axis=(1, 3))
    blocks = np.pad(blocks, 1, constant_values=not blocks.any())  # one must be uneven
    to_uneven = cell_distances(~blocks)[1:-1, 1:-1]
    # From any point of a block to any point of another: up to a block's diagonal nearer.
    even = np.clip(BLOCK * (to_uneven - np.sqrt(2)), 0, 255)
    return np.stack([even.astype(np.uint8), padded[::BLOCK, ::BLOCK]], axis=-1)
