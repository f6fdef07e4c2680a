"""The camera: its lens, and the projection between its picture and the floor.

The lens is the pinhole with radial and tangential distortion that ROS calls ``plumb_bob``
(Brown 1966; OpenCV's first five coefficients), read from a ``camera_info`` YAML file.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import yaml

from robot.geometry import Array


class CameraError(ValueError):
    """A camera description that cannot be right."""


@dataclass(frozen=True)
class Lens:
    """What the camera does to a ray of light; pixel centres have whole coordinates."""

    width: int
    height: int
    matrix: Array = field(repr=False)
    """(3, 3) intrinsic matrix K [px]."""
    distortion: Array = field(repr=False)
    """(5,) k1, k2, p1, p2, k3."""
    readout: float = 0.0
    """Rolling shutter: time from the exposure of the first row to that of the last [s]."""

    def project(self, points: Array) -> Array:
        """Pixels (n, 2) of points (n, 3) [m] in the camera frame; nan behind the camera.

        Beyond the widest angle at which the distortion is one-to-one the pixel is nan too: there
        the polynomial folds back and would put far points into the picture.
        """
        with np.errstate(divide="ignore", invalid="ignore"):
            ideal = points[:, :2] / points[:, 2:]
            seen = (points[:, 2] > 1e-9) & ((ideal**2).sum(axis=1) < self._widest_radius**2)
        pixels = np.full((len(points), 2), np.nan)
        if seen.any():
            on_plane = np.column_stack([ideal[seen], np.ones(int(seen.sum()))])
            found, _ = cv2.projectPoints(
                on_plane, np.zeros(3), np.zeros(3), self.matrix, self.distortion
            )
            pixels[seen] = found.reshape(-1, 2)
        return pixels

    def unproject(self, pixels: Array) -> Array:
        """Directions (n, 3), with z = 1, in the camera frame that pixels (n, 2) look along."""
        criteria = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 100, 1e-12)
        ideal = cv2.undistortPoints(
            pixels.reshape(-1, 1, 2).astype(np.float64),
            self.matrix,
            self.distortion,
            criteria=criteria,
        ).reshape(-1, 2)
        return np.column_stack([ideal, np.ones(len(ideal))])

    @cached_property
    def _widest_radius(self) -> float:
        """Largest r = tan(angle) up to which r (1 + k1 r^2 + k2 r^4 + k3 r^6) still grows."""
        k1, k2, _, _, k3 = self.distortion
        roots = np.roots([7 * k3, 5 * k2, 3 * k1, 1.0])  # of the slope, in r^2
        real = roots[np.isreal(roots) & (roots.real > 0)].real
        return float(np.sqrt(real.min())) if len(real) else np.inf

    @classmethod
    def from_yaml(cls, path: Path) -> Lens:
        """Read a ROS ``camera_info`` file (as camera_calibration writes it).

        ``rolling_shutter_readout`` [s] is a key of ours; ROS leaves it alone.

        Raises:
            CameraError: the file cannot be read, or a value cannot be right; names it.
        """
        try:
            content = yaml.safe_load(path.read_text(encoding="utf-8"))
        except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
            raise CameraError(f"{path}: no readable camera_info YAML: {error}") from error
        if not isinstance(content, dict):
            raise CameraError(f"{path}: expected the keys of a camera_info file")
        try:
            return cls(
                width=int(content["image_width"]),
                height=int(content["image_height"]),
                matrix=_matrix(content["camera_matrix"], 9).reshape(3, 3),
                distortion=_distortion(content),
                readout=float(content.get("rolling_shutter_readout", 0.0)),
            )
        except KeyError as error:
            raise CameraError(f"{path}: the key {error} is missing") from error
        except (TypeError, ValueError) as error:
            raise CameraError(f"{path}: {error}") from error

    def __post_init__(self) -> None:
        if not (1 <= self.width <= 16384 and 1 <= self.height <= 16384):
            raise CameraError(f"a picture of {self.width} x {self.height} px; valid is 1 to 16384")
        if self.matrix[0, 0] <= 0 or self.matrix[1, 1] <= 0:
            raise CameraError("the focal lengths in camera_matrix must be positive")
        if not 0 <= self.readout < 1:
            raise CameraError(f"rolling_shutter_readout is {self.readout} s; valid is 0 to 1")


def _matrix(entry: Any, count: int) -> Array:
    data = np.array(entry["data"], dtype=np.float64)
    if data.shape != (count,) or not np.isfinite(data).all():
        raise ValueError(f"expected {count} finite numbers under data, found {entry['data']!r}")
    return data


def _distortion(content: dict[str, Any]) -> Array:
    model = content.get("distortion_model", "plumb_bob")
    if model != "plumb_bob":
        raise ValueError(f"distortion_model is {model!r}; valid is plumb_bob")
    return _matrix(content["distortion_coefficients"], 5)


@dataclass(frozen=True)
class FloorView:
    """A camera over a floor: which floor point each pixel sees, in the robot frame."""

    lens: Lens
    robot_from_camera: Array = field(repr=False)
    """(4, 4) homogeneous transform; z = 0 of the robot frame is the floor."""

    @cached_property
    def floor_from_picture(self) -> Array:
        """(3, 3) projective transform from ideal image coordinates (x, y, 1) to the floor.

        Ideal means undistorted and divided by K. It is the inverse of the two columns of the
        rotation that span the floor, with the translation (Hartley and Zisserman 2004, ch. 8.1).
        """
        camera_from_robot = np.linalg.inv(self.robot_from_camera)
        picture_from_floor = camera_from_robot[:3, [0, 1, 3]]
        inverse: Array = np.linalg.inv(picture_from_floor)
        return inverse

    def floor_points(self, pixels: Array) -> Array:
        """Floor points (n, 2) [m] in the robot frame seen by pixels (n, 2); nan above horizon."""
        rays = self.lens.unproject(pixels)
        down = rays @ self.robot_from_camera[2, :3] < -1e-9
        floor = rays @ self.floor_from_picture.T
        with np.errstate(divide="ignore", invalid="ignore"):
            points: Array = floor[:, :2] / floor[:, 2:]
        points[~down] = np.nan
        return points

    def pixels(self, points: Array) -> Array:
        """Pixels (n, 2) that see floor points (n, 2) [m] of the robot frame; nan if none can."""
        on_floor = np.column_stack([points, np.zeros(len(points)), np.ones(len(points))])
        camera_from_robot = np.linalg.inv(self.robot_from_camera)
        return self.lens.project((on_floor @ camera_from_robot.T)[:, :3])

    def inside(self, pixels: Array, margin: float = 0.0) -> np.ndarray[Any, np.dtype[np.bool_]]:
        """Which pixels (n, 2) lie in the picture, at least a margin [px] from its border."""
        u, v = pixels[:, 0], pixels[:, 1]
        high_u, high_v = self.lens.width - 1 - margin, self.lens.height - 1 - margin
        with np.errstate(invalid="ignore"):
            return (u >= margin) & (u <= high_u) & (v >= margin) & (v <= high_v)
