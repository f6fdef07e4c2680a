"""Two common OpenCV pipelines to detect tape, on a bird's-eye view.

Both warp the picture to a view from above with precomputed tables, and find outlines in it. They
return ranges along the same rays as the line scanner: the nearest crossing from light to dark that
a ray can see, and whose other side is a tape's width away. OpenCV handles the pixels; the rest,
a few dozen lines and polygons against the rays, is compiled.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Generic, TypeVar

import cv2
import numpy as np
from numba import njit
from numpy.typing import NDArray

from robot.camera import FloorView
from robot.geometry import Array, heading_vectors
from robot.scanning.ray_table import RayTable

TAPE = (0.050, 0.012)
"""Width of tape and its tolerance [m], as in the line scanner."""


class BirdsEye:
    """The floor from above, with a pixel every few millimetres; row 0 is right, column 0 near."""

    def __init__(self, view: FloorView, table: RayTable, cell: float) -> None:
        self.cell = cell
        near, far = table.limits.T
        self.limits = table.limits
        self.directions = heading_vectors(table.bearings)
        ends = np.concatenate([self.directions * near[:, None], self.directions * far[:, None]])
        self.corner = np.nanmin(ends, axis=0) - 2 * cell
        self.size = np.ceil((np.nanmax(ends, axis=0) + 2 * cell - self.corner) / cell).astype(int)
        columns, rows = np.meshgrid(np.arange(self.size[0]), np.arange(self.size[1]))
        floor = np.column_stack([columns.ravel(), rows.ravel()]) * cell + self.corner
        pixels = view.pixels(floor).reshape(*columns.shape, 2).astype(np.float32)
        self._maps = cv2.convertMaps(pixels[..., 0], pixels[..., 1], cv2.CV_16SC2)

    def look(self, picture: NDArray[np.uint8], blur: int) -> NDArray[np.uint8]:
        """Return the view from above (h, w), smoothed over some cells; 0 means not smoothed."""
        above = cv2.remap(picture, *self._maps, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
        if blur:
            above = cv2.GaussianBlur(above, (blur, blur), 0)
        return np.asarray(above, dtype=np.uint8)

    def floor(self, pixels: Array) -> Array:
        """Return the points (..., 2) [m] of pixels (..., 2), in the robot frame."""
        points: Array = pixels * self.cell + self.corner
        return points


@dataclass(frozen=True)
class Settings:
    """Settings of a pipeline; lengths are in metres, so that they hold for any cell size."""

    cell: float = 0.002
    blur: int = 0


S = TypeVar("S", bound=Settings)


class Pipeline(ABC, Generic[S]):
    """A pipeline from a picture to ranges, by edges seen from above."""

    def __init__(self, view: FloorView, table: RayTable, settings: S) -> None:
        self.settings = settings
        self.birds_eye = BirdsEye(view, table, settings.cell)

    def scan(self, picture: NDArray[np.uint8]) -> Array:
        """Return the ranges (k,) [m] in a picture; inf if there is none."""
        pixels = self.edges(self.birds_eye.look(picture, self.settings.blur))
        return self.ranges(self.birds_eye.floor(pixels.reshape(-1, 2, 2)).reshape(-1, 4))

    @abstractmethod
    def edges(self, above: NDArray[np.uint8]) -> Array:
        """Return edges (n, 4) [px] in a view from above (h, w), with the dark side to the left."""

    @abstractmethod
    def ranges(self, edges: Array) -> Array:
        """Return the ranges (k,) [m] to edges (n, 4) [m]."""


@dataclass(frozen=True)
class HoughSettings(Settings):
    """Thresholds of the Canny detector, and steps, votes and lines of the Hough transform."""

    low: float = 50
    high: float = 150
    rho: float = 1.0
    theta: float = math.pi / 180
    votes: float = 0.05
    shortest: float = 0.05
    gap: float = 0.02


class HoughLines(Pipeline[HoughSettings]):
    """Bird's-eye view, Canny edges, and segments by the probabilistic Hough transform."""

    def edges(self, above: NDArray[np.uint8]) -> Array:
        """Return segments (n, 4) [px] of straight lines."""
        s = self.settings
        lines = cv2.HoughLinesP(
            cv2.Canny(above, s.low, s.high),
            s.rho,
            s.theta,
            max(1, round(s.votes / s.cell)),
            minLineLength=s.shortest / s.cell,
            maxLineGap=s.gap / s.cell,
        )
        if lines is None:
            return np.empty((0, 4))
        segments = np.asarray(lines, dtype=np.int32).reshape(-1, 4)
        return _dark_to_the_left(above, segments, 2.5 + 0.004 / s.cell)

    def ranges(self, edges: Array) -> Array:
        """Return the ranges to light-to-dark segments with a dark-to-light one behind them."""
        view = self.birds_eye
        return _ranges_to_segments(edges, view.directions, view.limits, *TAPE)


@dataclass(frozen=True)
class ContourSettings(Settings):
    """Block and offset of the threshold, and limits for outlines."""

    block: float = 0.2
    offset: float = 15
    simplify: float = 1.0
    """Points of a contour that are closer than this to its polygon are left out [px]."""
    smallest: float = 0.08
    """Shortest outline that counts [m]."""


class Contours(Pipeline[ContourSettings]):
    """Bird's-eye view, adaptive threshold, and the outlines of dark areas."""

    def edges(self, above: NDArray[np.uint8]) -> Array:
        """Return the sides (n, 4) [px] of the outlines."""
        s = self.settings
        block = round(s.block / s.cell) // 2 * 2 + 1
        dark = cv2.adaptiveThreshold(
            above, 255, cv2.ADAPTIVE_THRESH_MEAN_C, cv2.THRESH_BINARY_INV, block, s.offset
        )
        contours, _ = cv2.findContours(dark, cv2.RETR_CCOMP, cv2.CHAIN_APPROX_SIMPLE)
        rings = [
            _ring(cv2.approxPolyDP(contour, s.simplify, True))
            for contour in contours
            if len(contour) > 2 and cv2.arcLength(contour, True) > s.smallest / s.cell
        ]
        return np.concatenate([np.empty((0, 4)), *rings])

    def ranges(self, edges: Array) -> Array:
        """Return the ranges to outlines as wide as tape."""
        view = self.birds_eye
        # A contour runs through the outermost dark pixels: the edge is half a pixel outside.
        return _ranges_to_outlines(edges, view.directions, view.limits, *TAPE, view.cell / 2)


def _ring(polygon: cv2.typing.MatLike) -> Array:
    """Return the edges (n, 4) of a closed OpenCV polygon, with its inside to the left."""
    points = polygon.reshape(-1, 2)[::-1].astype(np.float64)
    return np.concatenate([points, np.roll(points, -1, axis=0)], axis=1)


@njit(cache=True, nogil=True)
def _dark_to_the_left(above: NDArray[np.uint8], segments: NDArray[np.int32], aside: float) -> Array:
    """Turn segments (n, 4) so that the darker side is to the left, by samples beside them."""
    height, width = above.shape
    turned = segments.astype(np.float64)
    for i in range(len(segments)):
        x0, y0, x1, y1 = turned[i]
        length = math.hypot(x1 - x0, y1 - y0)
        nx, ny = -(y1 - y0) / length * aside, (x1 - x0) / length * aside
        left = right = 0
        for j in range(1, 8):
            x, y = x0 + (x1 - x0) * j / 8, y0 + (y1 - y0) * j / 8
            column, row = min(max(int(x + nx), 0), width - 1), min(max(int(y + ny), 0), height - 1)
            left += above[row, column]
            column, row = min(max(int(x - nx), 0), width - 1), min(max(int(y - ny), 0), height - 1)
            right += above[row, column]
        if right < left:
            turned[i] = x1, y1, x0, y0
    return turned


@njit(cache=True, nogil=True)
def _crossing(edge: Array, dx: float, dy: float) -> tuple[float, float]:
    """Return the distance [m] at which a ray from the origin meets an edge, and the sine between.

    The sine is positive if the ray goes to the left side; the distance is inf for a miss.
    """
    ex, ey = edge[2] - edge[0], edge[3] - edge[1]
    cross = ex * dy - ey * dx
    if cross == 0:
        return np.inf, 0.0
    part = (edge[1] * dx - edge[0] * dy) / cross
    if not 0 <= part < 1:
        return np.inf, 0.0
    x, y = edge[0] + part * ex, edge[1] + part * ey
    return x * dx + y * dy, cross / math.hypot(ex, ey)


@njit(cache=True, nogil=True)
def _ranges_to_segments(
    segments: Array, directions: Array, limits: Array, width: float, tolerance: float
) -> Array:
    """Return on each ray the nearest entry with a segment of the other kind a width behind it."""
    ranges = np.full(len(directions), np.inf)
    for ray in range(len(directions)):
        dx, dy = directions[ray]
        for i in range(len(segments)):
            enters, sine = _crossing(segments[i], dx, dy)
            if sine <= 0 or not limits[ray, 0] <= enters < min(limits[ray, 1], ranges[ray]):
                continue
            for j in range(len(segments)):
                leaves, other = _crossing(segments[j], dx, dy)
                if other < 0 and abs((leaves - enters) * sine - width) <= tolerance:
                    ranges[ray] = enters
                    break
    return ranges


@njit(cache=True, nogil=True)
def _ranges_to_outlines(
    edges: Array,
    directions: Array,
    limits: Array,
    width: float,
    tolerance: float,
    outside: float,
) -> Array:
    """Return on each ray the nearest crossing into an outline with the next one a width away.

    Outlines have their inside to the left; the true edge lies a little outside of them [m].
    """
    ranges = np.full(len(directions), np.inf)
    distances = np.empty(len(edges))
    sines = np.empty(len(edges))
    for ray in range(len(directions)):
        dx, dy = directions[ray]
        count = 0
        for i in range(len(edges)):
            distance, sine = _crossing(edges[i], dx, dy)
            if limits[ray, 0] <= distance <= limits[ray, 1]:
                distances[count], sines[count] = distance, sine
                count += 1
        order = np.argsort(distances[:count])
        for n in range(count - 1):
            i, j = order[n], order[n + 1]
            across = (distances[j] - distances[i]) * sines[i] + 2 * outside
            if sines[i] > 0 and sines[j] < 0 and abs(across - width) <= tolerance:
                ranges[ray] = distances[i] - outside / sines[i]
                break
    return ranges
