"""The camera: its lens, and the projection between its picture and the floor.

The lens is a pinhole with radial and tangential distortion, which ROS calls ``plumb_bob``
(Brown 1966; OpenCV's first five coefficients). It is read from a ``camera_info`` YAML file.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import yaml
from numpy.typing import NDArray

from robot.errors import BrickPoseError
from robot.geometry import Array
from robot.undistortion import undistorted

LARGEST_BYTES = 64 << 10
"""Largest camera_info file: reading YAML takes seconds for each megabyte."""

FOUND_PX = 0.01
"""The direction found for a pixel must project back this close to the pixel [px]."""


class CameraError(BrickPoseError, ValueError):
    """An invalid camera description."""


@dataclass(frozen=True)
class Lens:
    """Model of the lens: which pixel a ray of light hits; pixel centres have whole coordinates."""

    width: int
    height: int
    matrix: Array = field(repr=False)
    """(3, 3) intrinsic matrix K [px]."""
    distortion: Array = field(repr=False)
    """(5,) k1, k2, p1, p2, k3."""
    readout: float = 0.0
    """Rolling shutter: time from the exposure of the first row to that of the last [s]."""

    def project(self, points: Array) -> Array:
        """Return the pixels (n, 2) of points (n, 3) [m] in the camera frame; nan behind the camera.

        The pixel is also nan beyond the widest angle at which the distortion is one-to-one. There
        the polynomial folds back and would put far points into the picture.
        """
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            ideal = points[:, :2] / points[:, 2:]
            pixels = self._distorted(ideal)
            pixels[~((points[:, 2] > 1e-9) & self._one_to_one(ideal))] = np.nan
        return pixels

    def unproject(self, pixels: Array) -> Array:
        """Return the viewing directions (n, 3) of pixels (n, 2) in the camera frame, with z = 1.

        They are nan where the model has none: far from the centre, the lens may bend no ray to a
        pixel.
        """
        bent = (pixels - self.matrix[:2, 2]) / self.matrix[[0, 1], [0, 1]]
        ideal = undistorted(np.ascontiguousarray(bent), self.distortion, self._widest_radius)
        directions = np.column_stack([ideal, np.ones(len(ideal))])
        lost = np.flatnonzero(np.isnan(ideal[:, 0]))
        if len(lost):
            directions[lost] = self._searched(pixels[lost])
        return directions

    def _searched(self, pixels: Array) -> Array:
        """Do the same as ``unproject``, slower, for pixels where Newton's method fails."""
        criteria = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 1000, 1e-12)
        ideal = cv2.undistortPoints(
            pixels.reshape(-1, 1, 2).astype(np.float64),
            self.matrix,
            self.distortion,
            criteria=criteria,
        ).reshape(-1, 2)
        directions: Array = np.column_stack([ideal, np.ones(len(ideal))]).astype(np.float64)
        # The search returns a point even if there is no solution.
        offset = np.abs(self.project(directions) - pixels).max(axis=1)
        directions[~(offset < FOUND_PX)] = np.nan
        return directions

    def _distorted(self, ideal: Array) -> Array:
        """Return the pixels (n, 2) of ideal image coordinates (n, 2), by Brown's formula."""
        k1, k2, p1, p2, k3 = self.distortion
        x, y = ideal.T
        xy, r2 = x * y, x * x + y * y
        radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3))
        bent_x = x * radial + 2 * p1 * xy + p2 * (r2 + 2 * x * x)
        bent_y = y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * xy
        (fx, _, cx), (_, fy, cy), _ = self.matrix
        return np.column_stack([fx * bent_x + cx, fy * bent_y + cy])

    def _one_to_one(self, ideal: Array) -> NDArray[np.bool_]:
        """Return whether ideal image coordinates (n, 2) lie where the distortion is one-to-one."""
        within: NDArray[np.bool_] = (ideal**2).sum(axis=1) < self._widest_radius**2
        return within

    @cached_property
    def _widest_radius(self) -> float:
        """Largest r = tan(angle) up to which r (1 + k1 r^2 + k2 r^4 + k3 r^6) still grows."""
        k1, k2, _, _, k3 = self.distortion
        # The slope is solved for 1 / r^2, so that a coefficient near zero does no harm.
        roots = np.roots([1.0, 3 * k1, 5 * k2, 7 * k3])
        real = roots[np.isreal(roots) & (roots.real > 0)].real
        return float(1 / np.sqrt(real.max())) if len(real) else np.inf

    @classmethod
    def from_yaml(cls, path: Path) -> Lens:
        """Read a ROS ``camera_info`` file, as camera_calibration writes it.

        ``rolling_shutter_readout`` [s] is a key of BrickPose; ROS ignores it.

        Raises:
            CameraError: the file cannot be read, or a value is invalid; the message names it.
        """
        try:
            if path.stat().st_size > LARGEST_BYTES:
                raise CameraError(f"{path} is too large; valid are up to {LARGEST_BYTES} bytes")
            # BaseLoader keeps values as text: no YAML tag can make it construct an object.
            content = yaml.load(path.read_text(encoding="utf-8"), yaml.BaseLoader)
        except CameraError:
            raise
        except (OSError, ValueError, RecursionError, yaml.YAMLError) as error:
            raise CameraError(f"{path}: no readable camera_info YAML: {error}") from error
        if not isinstance(content, dict):
            raise CameraError(f"{path}: expected the keys of a camera_info file")
        try:
            return cls(
                width=_whole(content, "image_width"),
                height=_whole(content, "image_height"),
                matrix=_numbers(content, "camera_matrix", 9).reshape(3, 3),
                distortion=_distortion(content),
                readout=_finite(content.get("rolling_shutter_readout", "0")),
            )
        except KeyError as error:
            raise CameraError(f"{path}: the key {error} is missing") from error
        except ValueError as error:
            raise CameraError(f"{path}: {error}") from error

    def __post_init__(self) -> None:
        if not (1 <= self.width <= 16384 and 1 <= self.height <= 16384):
            raise CameraError(f"a picture of {self.width} x {self.height} px; valid is 1 to 16384")
        if not (self.matrix[0, 0] > 0 and self.matrix[1, 1] > 0):
            raise CameraError("the focal lengths in camera_matrix must be positive")
        if self.matrix[[0, 1, 2, 2, 2], [1, 0, 0, 1, 2]].tolist() != [0, 0, 0, 0, 1]:
            raise CameraError("camera_matrix must be fx 0 cx, 0 fy cy, 0 0 1")
        if not 0 <= self.readout < 1:
            raise CameraError(f"rolling_shutter_readout is {self.readout} s; valid is 0 to 1")


def _whole(content: dict[str, Any], key: str) -> int:
    text = content[key]
    if not (isinstance(text, str) and re.fullmatch(r"\d{1,9}", text)):
        raise ValueError(f"{key} is {_shown(text)}; valid is a whole number")
    return int(text)


def _finite(text: Any) -> float:
    """Return a text as a number; nan if it is not a number."""
    try:
        return float(text) if isinstance(text, str) else math.nan
    except ValueError:
        return math.nan


def _numbers(content: dict[str, Any], key: str, count: int) -> Array:
    entry = content[key]
    data = entry.get("data") if isinstance(entry, dict) else None
    values = np.array([_finite(text) for text in data] if isinstance(data, list) else [])
    if len(values) != count or not np.isfinite(values).all():
        raise ValueError(f"{key} needs a list of {count} finite numbers under data")
    return values


def _shown(value: Any) -> str:
    # Lists are not shown: with aliases, a few lines of YAML can hold billions of values.
    return repr(value)[:80] if isinstance(value, str) else type(value).__name__


def _distortion(content: dict[str, Any]) -> Array:
    model = content.get("distortion_model", "plumb_bob")
    if model != "plumb_bob":
        raise ValueError(f"distortion_model is {_shown(model)}; valid is plumb_bob")
    return _numbers(content, "distortion_coefficients", 5)


@dataclass(frozen=True)
class FloorView:
    """A camera above the floor: which floor point each pixel sees, in the robot frame."""

    lens: Lens
    robot_from_camera: Array = field(repr=False)
    """(4, 4) homogeneous transform; z = 0 of the robot frame is the floor."""

    @cached_property
    def floor_from_picture(self) -> Array:
        """(3, 3) projective transform from ideal image coordinates (x, y, 1) to the floor.

        Ideal means undistorted and divided by K. The transform is the inverse of a matrix of three
        columns: the two columns of the rotation that span the floor, and the translation (Hartley
        and Zisserman 2004, ch. 8.1).
        """
        camera_from_robot = np.linalg.inv(self.robot_from_camera)
        picture_from_floor = camera_from_robot[:3, [0, 1, 3]]
        inverse: Array = np.linalg.inv(picture_from_floor)
        return inverse

    def floor_points(self, pixels: Array) -> Array:
        """Return the floor points (n, 2) [m], in the robot frame, that pixels (n, 2) see.

        They are nan above the horizon.
        """
        rays = self.lens.unproject(pixels)
        down = rays @ self.robot_from_camera[2, :3] < -1e-9
        floor = rays @ self.floor_from_picture.T
        with np.errstate(divide="ignore", invalid="ignore"):
            points: Array = floor[:, :2] / floor[:, 2:]
        points[~down] = np.nan
        return points

    def pixels(self, points: Array) -> Array:
        """Return the pixels (n, 2) that see floor points (n, 2) [m] of the robot frame, or nan."""
        on_floor = np.column_stack([points, np.zeros(len(points)), np.ones(len(points))])
        camera_from_robot = np.linalg.inv(self.robot_from_camera)
        return self.lens.project((on_floor @ camera_from_robot.T)[:, :3])

    def inside(self, pixels: Array, margin: float = 0.0) -> np.ndarray[Any, np.dtype[np.bool_]]:
        """Return which pixels (n, 2) lie in the picture, at least a margin [px] from its border."""
        u, v = pixels[:, 0], pixels[:, 1]
        high_u, high_v = self.lens.width - 1 - margin, self.lens.height - 1 - margin
        with np.errstate(invalid="ignore"):
            return (u >= margin) & (u <= high_u) & (v >= margin) & (v <= high_v)
