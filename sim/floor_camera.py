"""The camera's picture of the floor, by projection instead of by a general renderer.

Each pixel sees one point of the floor, and the lens does not change. So the floor points of each
pixel, and of several samples inside it, are computed once in the robot frame; a picture is then one
look-up in the drawing of the floor. The samples of a pixel are spread over its height, because the
floor is seen at a slant and would alias, and over the exposure time, which gives motion blur. Rows
are exposed one after the other, as with a rolling shutter.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import cv2
import numpy as np
from numba import njit
from numpy.typing import NDArray

from robot.camera import FloorView
from robot.fields.field import FloorPicture
from robot.geometry import Array, Pose2, Twist2
from robot.settings import check_settings, setting
from sim.clutter import KINDS, add_clutter, add_glare, add_uneven_light

SAMPLES = (4, 8)
"""Samples over the height of a pixel; rows whose pixels cover more floor use more."""

FOOTPRINT_M = 0.0015
"""Length of floor, along the view, that one sample should cover at most [m]."""


@dataclass(frozen=True)
class CameraSettings:
    """How a real camera differs from a perfect one; defaults are of a Pi camera indoors."""

    frame_rate: float = setting(30.0, "Pictures a second", unit="1/s", low=1, high=120)
    exposure: float = setting(
        0.010, "Exposure time; what moves meanwhile is blurred", unit="s", low=0, high=0.1
    )
    delay: float = setting(
        0.005,
        "Time from the last row's exposure until the picture is in memory",
        unit="s",
        low=0,
        high=1,
    )
    blur: float = setting(0.7, "Standard deviation of the lens blur", unit="px", low=0, high=10)
    noise: float = setting(
        3.0, "Standard deviation of the sensor noise, of 255 grey levels", low=0, high=64
    )
    vignetting: float = setting(
        0.25, "Share of the light that is lost in the corners", low=0, high=0.9
    )
    stamp_error: float = setting(
        0.0, "How much later a picture is stamped than it was exposed", unit="s", low=0, high=1
    )
    light: float = setting(
        1.0, "Share of the light that there is; noise stays as it is", low=0.01, high=1
    )
    uneven_light: float = setting(
        0.0, "Share of the light that is lost where the floor is farthest from the lamp",
        low=0, high=0.95,
    )  # fmt: skip
    clutter: str = setting(
        "none", "Things on the floor that are no tape and in no map", choices=KINDS
    )

    glare: float = setting(
        0.0, "Grey levels that the reflections of lamps on the floor add at most", low=0, high=255
    )
    floor_scale: float = setting(
        1.0,
        "How much larger the floor is than its drawing: nobody tapes exactly",
        low=0.8,
        high=1.25,
    )
    lost_share: float = setting(
        0.0, "Share of the pictures that never arrive, in bursts", low=0, high=0.99
    )
    lost_burst: float = setting(
        0.0, "How long such a burst lasts on average; 0 is one picture", unit="s", low=0, high=60
    )
    gap: float = setting(
        0.0,
        "How long no picture arrives, once in each 15 s, at a moment drawn by chance",
        unit="s",
        low=0,
        high=14,
    )

    def __post_init__(self) -> None:
        check_settings(self)


class FloorCamera:
    """Takes pictures of one floor through one lens."""

    def __init__(
        self,
        view: FloorView,
        floor: FloorPicture,
        settings: CameraSettings,
        rng: np.random.Generator,
    ) -> None:
        # Separate streams: noise is the same with and without clutter.
        for_clutter, for_light, for_glare = rng.spawn(3)
        littered = add_clutter(floor.scaled(settings.floor_scale), settings.clutter, for_clutter)
        lit = add_uneven_light(littered, settings.uneven_light, for_light)
        self._floor = add_glare(lit, settings.glare, for_glare)
        self._settings = settings
        self._rng = rng
        self._bands = _bands(view)
        self._looks_at, self._times = _samples(view, self._bands, settings.exposure)
        self._light = _vignette(view.lens.width, view.lens.height, settings.vignetting)
        self._light *= settings.light
        self._noise = _noise_table(view, settings.noise, rng)
        self._size = (view.lens.height, view.lens.width)

    def picture(self, map_from_robot: Pose2, twist: Twist2) -> NDArray[np.uint8]:
        """Take a grey picture (h, w) at a pose in the map, while moving with a twist.

        The robot is at the pose in the middle of the exposure of the middle row.
        """
        affine = _sample_affines(self._floor.pixel_from_map, map_from_robot, twist, self._times)
        columns = np.empty(self._looks_at.shape[:2], dtype=np.float32)
        rows = np.empty_like(columns)
        _apply_affines(self._looks_at, affine, columns, rows)
        samples = cv2.remap(
            self._floor.image,
            columns,
            rows,
            cv2.INTER_LINEAR,
            borderMode=cv2.BORDER_CONSTANT,
            borderValue=self._floor.border,
        )
        picture = _average(np.asarray(samples, dtype=np.uint8), self._bands, self._size)
        return self._develop(picture)

    def _develop(self, ideal: NDArray[np.uint8]) -> NDArray[np.uint8]:
        picture: cv2.typing.MatLike = ideal
        if self._settings.blur > 0:
            picture = cv2.GaussianBlur(picture, (0, 0), self._settings.blur)
        picture = cv2.multiply(picture, self._light, dtype=cv2.CV_8U)
        if self._settings.noise > 0:
            height, width = self._size
            # Noise is taken from a random position in a table: to draw it costs 5 ms a picture.
            row, column = self._rng.integers(0, _NOISE_MARGIN, 2)
            noise = self._noise[row : row + height, column : column + width]
            picture = cv2.add(picture, noise, dtype=cv2.CV_8U)
        return np.asarray(picture, dtype=np.uint8)


@dataclass(frozen=True, slots=True)
class _Band:
    """Rows of the picture, from first to last (exclusive), with the same number of samples."""

    first: int
    last: int
    samples: int


def _bands(view: FloorView) -> list[_Band]:
    """Cut the picture into bands; rows whose pixels cover much floor use more samples."""
    height = view.lens.height
    middle = np.full(height + 1, (view.lens.width - 1) / 2)
    floor = view.floor_points(np.column_stack([middle, np.arange(height + 1) - 0.5]))
    footprint = np.linalg.norm(np.diff(floor, axis=0), axis=1)
    wanted = np.nan_to_num(footprint / FOOTPRINT_M, nan=np.inf)
    level = np.searchsorted(SAMPLES[:-1], wanted)
    cuts = [0, *(np.flatnonzero(np.diff(level)) + 1), height]
    return [_Band(a, b, SAMPLES[level[a]]) for a, b in pairwise(cuts)]


def _samples(
    view: FloorView, bands: list[_Band], exposure: float
) -> tuple[NDArray[np.float32], Array]:
    """Return the samples' floor points (s, w, 2) [m] and times (s,) [s].

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
    pixels = np.stack(np.broadcast_arrays(np.arange(lens.width), v[:, None]), axis=-1)
    floor = view.floor_points(pixels.reshape(-1, 2).astype(np.float64))
    # Above the horizon there is no floor: use a point so far away that it has the border's tone.
    floor = np.nan_to_num(floor, nan=1e6).reshape(len(v), lens.width, 2)
    return floor.astype(np.float32), np.concatenate(times)


def _bit_reversed(count: int) -> list[int]:
    bits = count.bit_length() - 1
    return [int(f"{i:0{bits}b}"[::-1], 2) for i in range(count)]


def _sample_affines(
    pixel_from_map: Array, map_from_robot: Pose2, twist: Twist2, times: Array
) -> NDArray[np.float32]:
    """Return affines (s, 2, 3) from the robot frame at each time to pixels of the floor picture."""
    pixel = np.vstack([pixel_from_map, [0, 0, 1]])
    # Between nine moments of a picture the motion is straight to well under a micrometre.
    knots = np.linspace(times.min(), times.max(), 9)
    moments = [map_from_robot @ twist.integrate(float(t)) for t in knots]
    affines = np.array([(pixel @ _homogeneous(pose))[:2].ravel() for pose in moments])
    between = [np.interp(times, knots, column) for column in affines.T]
    return np.stack(between, axis=1).reshape(-1, 2, 3).astype(np.float32)


def _homogeneous(pose: Pose2) -> Array:
    columns = pose.apply(np.array([[1.0, 0.0], [0.0, 1.0], [0.0, 0.0]]))
    origin = columns[2]
    return np.column_stack(
        [
            np.append(columns[0] - origin, 0.0),
            np.append(columns[1] - origin, 0.0),
            np.append(origin, 1.0),
        ]
    )


@njit(cache=True, nogil=True, fastmath=True)
def _apply_affines(
    points: NDArray[np.float32],
    affines: NDArray[np.float32],
    columns: NDArray[np.float32],
    rows: NDArray[np.float32],
) -> None:
    for i in range(points.shape[0]):
        a, b, c = affines[i, 0]
        d, e, f = affines[i, 1]
        for j in range(points.shape[1]):
            x, y = points[i, j, 0], points[i, j, 1]
            columns[i, j] = a * x + b * y + c
            rows[i, j] = d * x + e * y + f


def _average(
    samples: NDArray[np.uint8], bands: list[_Band], size: tuple[int, int]
) -> NDArray[np.uint8]:
    picture = np.empty(size, dtype=np.uint8)
    start = 0
    for band in bands:
        height = band.last - band.first
        rows = samples[start : start + height * band.samples]
        cv2.resize(
            rows, (size[1], height), picture[band.first : band.last], interpolation=cv2.INTER_AREA
        )
        start += height * band.samples
    return picture


def _vignette(width: int, height: int, lost: float) -> NDArray[np.float32]:
    """Share of the light left (h, w); the loss grows with the squared distance from the middle."""
    x = np.linspace(-1, 1, width)
    y = np.linspace(-1, 1, height)[:, None]
    return (1 - lost * (x * x + y * y) / 2).astype(np.float32)


_NOISE_MARGIN = 64


def _noise_table(view: FloorView, sd: float, rng: np.random.Generator) -> NDArray[np.int16]:
    shape = (view.lens.height + _NOISE_MARGIN, view.lens.width + _NOISE_MARGIN)
    return np.rint(rng.normal(0, sd, shape)).astype(np.int16)
