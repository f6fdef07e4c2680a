"""The floor before the robot, seen from above: a patch of the picture, projected to the ground."""

from __future__ import annotations

from dataclasses import dataclass, field

import cv2
import numpy as np
from numpy.typing import NDArray

from robot.camera import FloorView
from robot.errors import BrickPoseError
from robot.geometry import Array
from robot.picture_odometry.settings import PictureOdometrySettings

SHRUNK = 2
"""The picture is averaged over so many pixels in each direction first: nearby pixels see 0.35 mm,
and whatever is left out between two samples is only noise."""
ROWS = 16
"""So many rows of a picture tell its noise."""
SMALLEST = 24
"""Fewest pixels of a patch's side."""


class GroundError(BrickPoseError, ValueError):
    """The camera does not see the floor where it is asked for."""


@dataclass(frozen=True, eq=False)
class GroundView:
    """Looks at a rectangle of the floor from above: rows run backward, columns to the right.

    The middle of pixel (row, column) is ``corner - resolution * (row, column)`` in the robot frame.
    """

    corner: tuple[float, float]
    """x and y of the first pixel's middle: the left one of the farthest row [m]."""
    resolution: float
    """Side of a pixel [m]."""
    shape: tuple[int, int]
    """Rows and columns."""
    rows: Array = field(repr=False)
    """(h,) the picture's row that each row shows, in the middle."""
    _used: tuple[int, int]
    """First row of the picture that is used, and the one after the last."""
    _maps: tuple[cv2.typing.MatLike, cv2.typing.MatLike] = field(repr=False)

    @classmethod
    def of(cls, view: FloorView, settings: PictureOdometrySettings) -> GroundView:
        """Return what a camera sees of the rectangle in the settings.

        Raises:
            GroundError: it does not see all of it; names what it would see.
        """
        size = settings.resolution
        height = int((settings.farthest - settings.nearest) / size)
        width = int(settings.width / size)
        if min(height, width) < SMALLEST:
            raise GroundError(
                f"the compared floor has {height} x {width} px; valid are {SMALLEST} and more"
            )
        x: Array = settings.farthest - size * (np.arange(height, dtype=np.float64) + 0.5)
        y: Array = settings.width / 2 - size * (np.arange(width, dtype=np.float64) + 0.5)
        return cls._over(view, x, y, size)

    @classmethod
    def around(cls, view: FloorView, sides: tuple[float, float, float], size: float) -> GroundView:
        """Return a view of the nearest and farthest x, and of a width [m], seen or not."""
        nearest, farthest, wide = sides
        x: Array = np.arange(farthest, nearest, -size, dtype=np.float64)
        y: Array = np.arange(wide / 2, -wide / 2, -size, dtype=np.float64)
        return cls._over(view, x, y, size, whole=False)

    @classmethod
    def _over(
        cls, view: FloorView, x: Array, y: Array, size: float, *, whole: bool = True
    ) -> GroundView:
        shape = len(x), len(y)
        points = np.column_stack([np.repeat(x, len(y)), np.tile(y, len(x))])
        pixels = view.pixels(points)
        if whole and not view.inside(pixels, 1.0).all():
            seen = points[view.inside(pixels, 1.0)]
            least, most = (seen.min(axis=0), seen.max(axis=0)) if len(seen) else (np.zeros(2),) * 2
            raise GroundError(
                f"the camera does not see all floor from {x[-1]:.3f} to {x[0]:.3f} m, "
                f"{2 * y[0]:.3f} m wide; of it it sees x {least[0]:.3f} to {most[0]:.3f} m, "
                f"y {least[1]:.3f} to {most[1]:.3f} m"
            )
        pixels = np.nan_to_num(pixels, nan=-1e4).reshape(*shape, 2)
        inside = pixels[(pixels > -1).all(axis=2)]
        last = view.lens.height // SHRUNK * SHRUNK
        first = int(np.clip(inside[:, 1].min() - 2, 0, last - SHRUNK)) // SHRUNK * SHRUNK
        end = int(np.clip(inside[:, 1].max() + 4, first + SHRUNK, last)) // SHRUNK * SHRUNK
        small = (pixels - (0, first) - (SHRUNK - 1) / 2) / SHRUNK
        maps = cv2.convertMaps(
            small[..., 0].astype(np.float32), small[..., 1].astype(np.float32), cv2.CV_16SC2
        )
        middle = pixels[:, len(y) // 2, 1]
        return cls((x[0], y[0]), size, shape, middle, (first, end), maps)

    @property
    def middle(self) -> Array:
        """(2,) the patch's middle, in the robot frame [m]."""
        height, width = self.shape
        return np.array(self.corner) - self.resolution * np.array([height - 1, width - 1]) / 2

    def noise(self, picture: NDArray[np.uint8]) -> float:
        """Return about the standard deviation of a picture's noise [grey levels]; not too little.

        It is what three neighbours of a row differ by, in the median: a floor's grain is larger.
        """
        first, end = self._used
        some = picture[first : end : max(1, (end - first) // ROWS)]
        grey = (some if some.ndim == 2 else some[..., 1]).astype(np.int16)
        apart = np.abs(grey[:, :-2] - 2 * grey[:, 1:-1] + grey[:, 2:])
        counts = np.bincount(apart.ravel())
        # Of whole numbers, the median within its step.
        below = np.cumsum(counts)
        step = int(np.searchsorted(below, below[-1] / 2))
        part = (below[-1] / 2 - (below[step - 1] if step else 0)) / counts[step]
        return float(max(step - 0.5 + part, 0.2) / 0.6745 / np.sqrt(6))

    def project(self, picture: NDArray[np.uint8]) -> NDArray[np.uint8]:
        """Return the floor from above (h, w) of a picture, grey (h, w) or BGR (h, w, 3)."""
        first, end = self._used
        used: cv2.typing.MatLike = picture[first:end]
        size = picture.shape[1] // SHRUNK, (end - first) // SHRUNK
        used = cv2.resize(used, size, interpolation=cv2.INTER_AREA)
        if used.ndim == 3:
            used = cv2.cvtColor(used, cv2.COLOR_BGR2GRAY)
        return np.asarray(
            cv2.remap(used, *self._maps, cv2.INTER_LINEAR, borderValue=0), dtype=np.uint8
        )
