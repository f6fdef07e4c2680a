"""Where each ray of the line scanner runs through the picture, computed once for a camera."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import NDArray

from robot.camera import FloorView
from robot.geometry import Array, heading_vectors

MARGIN_PX = 3.0
"""Rays keep at least this far from the picture's border, so that interpolation and blur stay
inside."""

BESIDE_PX = 1.5
"""Rays keep at least a sample's step and this far from the border, because the search for an edge
extends up to a sample beyond a ray's ends."""


@dataclass(frozen=True, eq=False)
class RayTable:
    """k rays around a centre on the floor, each a row of at most m samples in the picture."""

    centre: Array
    """(2,) [m] in the robot frame."""
    bearings: Array
    """(k,) [rad]"""
    counts: NDArray[np.int32]
    """(k,) number of samples in use of the row; the rest of the row repeats the last one."""
    distances: Array = field(repr=False)
    """(k, m) distance of each sample from the centre [m], increasing along a row."""
    pixels: NDArray[np.float32] = field(repr=False)
    """(k, m, 2) position of each sample in the picture."""
    pixel_indices: NDArray[np.uint32] = field(repr=False)
    """(k, m) index of the pixel nearest to each sample, counted row by row."""

    @staticmethod
    def build(
        view: FloorView,
        bearings: Array,
        *,
        centre_x: float,
        range_max: float,
        step_px: float,
    ) -> RayTable:
        """Follow each ray over the floor and sample it at even steps in the picture.

        The same arguments give the same table, which nobody changes.

        Args:
            bearings: (k,) [rad] in the robot frame.
            centre_x: where the rays start, ahead of the robot's origin [m].
            range_max: how far the rays are followed [m].
            step_px: distance of the samples in the picture [px].
        """
        return _built(view, tuple(bearings.tolist()), centre_x, range_max, step_px)

    @cached_property
    def limits(self) -> Array:
        """(k, 2) nearest and farthest distance [m] that each ray sees; nan if it sees nothing."""
        last = np.maximum(self.counts - 1, 0)
        ends = np.column_stack([self.distances[:, 0], self.distances[np.arange(len(last)), last]])
        ends[self.counts == 0] = np.nan
        ends.setflags(write=False)
        return ends

    def lines(self, points: int) -> Array:
        """Return each ray as a line of pixels (k, points, 2) to draw, bent as the lens bends it."""
        parts = np.linspace(0, 1, points)
        index = np.rint(parts * np.maximum(self.counts - 1, 0)[:, None]).astype(int)
        return np.take_along_axis(self.pixels, index[:, :, None], axis=1).astype(np.float64)


@lru_cache(maxsize=4)
def _built(
    view: FloorView, bearings: tuple[float, ...], centre_x: float, range_max: float, step_px: float
) -> RayTable:
    directions = np.array(bearings)
    rows = [_follow(view, centre_x, b, range_max, step_px) for b in heading_vectors(directions)]
    counts = np.array([len(distances) for distances, _ in rows], dtype=np.int32)
    longest = max(int(counts.max()), 3)
    pixels = np.stack([_pad(pixels, longest) for _, pixels in rows])
    columns, lines = np.rint(pixels).astype(np.int32).transpose(2, 0, 1)
    return RayTable(
        centre=np.array([centre_x, 0.0]),
        bearings=directions,
        counts=counts,
        distances=np.stack([_pad(distances, longest) for distances, _ in rows]),
        pixels=pixels.astype(np.float32),
        pixel_indices=(lines * view.lens.width + columns).astype(np.uint32),
    )


def _follow(
    view: FloorView, centre_x: float, direction: Array, range_max: float, step_px: float
) -> tuple[Array, Array]:
    """Return distances (m,) and pixels (m, 2) of one ray at even steps in the picture."""
    dense = np.linspace(0.0, range_max, 1 + math.ceil(range_max / 0.0005))
    pixels = view.pixels(dense[:, None] * direction + (centre_x, 0.0))
    inside = np.flatnonzero(view.inside(pixels, max(MARGIN_PX, step_px + BESIDE_PX)))
    if len(inside) < 2:
        return np.empty(0), np.empty((0, 2))
    gaps = np.flatnonzero(np.diff(inside) > 1)
    run = inside[: gaps[0] + 1] if len(gaps) else inside
    along = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(pixels[run], axis=0), axis=1))])
    even = np.arange(0, along[-1], step_px)
    distances = np.interp(even, along, dense[run])
    return distances, view.pixels(distances[:, None] * direction + (centre_x, 0.0))


def _pad(rows: Array, length: int) -> Array:
    if len(rows) == 0:
        return np.zeros((length, *rows.shape[1:]))
    repeat: Array = np.concatenate([rows, np.repeat(rows[-1:], length - len(rows), axis=0)])
    return repeat
