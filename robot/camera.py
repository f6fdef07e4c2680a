"""The camera: its lens, and the projection between its picture and the floor.

The lens is a pinhole with one of the distortions that ROS names (``robot/distortion.py``).
``robot/description/lens_file.py`` reads it, and ``robot/lens_files`` what other programs write.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from robot.distortion import COEFFICIENTS, Distortion, distortion_of
from robot.errors import BrickPoseError
from robot.geometry import Array

GREATEST_SKEW = 0.1
"""Greatest skew, as a share of the focal length: calibrations of real lenses have 0.01."""


class CameraError(BrickPoseError, ValueError):
    """An invalid camera description."""


@dataclass(frozen=True, eq=False)
class Lens:
    """Model of the lens: which pixel a ray of light hits; pixel centres have whole coordinates."""

    width: int
    height: int
    matrix: Array = field(repr=False)
    """(3, 3) intrinsic matrix K [px]: fx, skew, cx; 0, fy, cy; 0, 0, 1. ROS's calibration of
    fisheye lenses fits a skew."""
    distortion: Array = field(repr=False)
    """Coefficients of the model: (5,) k1, k2, p1, p2, k3 of plumb_bob."""
    readout: float = 0.0
    """Rolling shutter: time from the exposure of the first row to that of the last [s]."""
    model: str = "plumb_bob"
    """plumb_bob, rational_polynomial or equidistant."""

    def project(self, points: Array) -> Array:
        """Return the pixels (n, 2) of points (n, 3) [m] in the camera frame; nan behind the camera.

        The pixel is also nan beyond the widest angle at which the distortion is one-to-one. There
        the polynomial folds back and would put far points into the picture.
        """
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            ideal = points[:, :2] / points[:, 2:]
            (fx, skew, cx), (_, fy, cy), _ = self.matrix
            bent = self._bending.bend(ideal)
            pixels: Array = bent * (fx, fy) + (cx, cy)
            if skew:
                pixels[:, 0] += skew * bent[:, 1]
            pixels[~((points[:, 2] > 1e-9) & self._one_to_one(ideal))] = np.nan
        return pixels

    def unproject(self, pixels: Array) -> Array:
        """Return the viewing directions (n, 3) of pixels (n, 2) in the camera frame, with z = 1.

        They are nan where the model has none: far from the centre, the lens may bend no ray to a
        pixel.
        """
        (fx, skew, cx), (_, fy, cy), _ = self.matrix
        bent = (pixels - (cx, cy)) / (fx, fy)
        if skew:
            bent[:, 0] -= skew / fx * bent[:, 1]
        ideal = self._bending.straighten(bent)
        return np.column_stack([ideal, np.where(np.isnan(ideal[:, 0]), np.nan, 1.0)])

    @property
    def parameters(self) -> dict[str, float]:
        """Its numbers by name: focal lengths and principal point [px], coefficients."""
        names = ("fx", "fy", "cx", "cy", *COEFFICIENTS[self.model])
        values = [*self.matrix[[0, 1], [0, 1]], *self.matrix[:2, 2], *self.distortion]
        return {name: float(value) for name, value in zip(names, values, strict=True)}

    def _one_to_one(self, ideal: Array) -> NDArray[np.bool_]:
        """Return whether ideal image coordinates (n, 2) lie where the distortion is one-to-one."""
        within: NDArray[np.bool_] = (ideal**2).sum(axis=1) < self._bending.widest**2
        return within

    @cached_property
    def _bending(self) -> Distortion:
        return distortion_of(self.model, self.distortion)

    def __post_init__(self) -> None:
        if not (1 <= self.width <= 16384 and 1 <= self.height <= 16384):
            raise CameraError(f"a picture of {self.width} x {self.height} px; valid is 1 to 16384")
        known = COEFFICIENTS.get(self.model)
        if known is None or len(self.distortion) != len(known):
            raise CameraError(
                f"{len(self.distortion)} coefficients of distortion_model {self.model}; valid are "
                + ", ".join(f"{len(each)} of {name}" for name, each in COEFFICIENTS.items())
            )
        if not (self.matrix[0, 0] > 0 and self.matrix[1, 1] > 0):
            raise CameraError("the focal lengths in camera_matrix must be positive")
        if self.matrix[[1, 2, 2, 2], [0, 0, 1, 2]].tolist() != [0, 0, 0, 1]:
            raise CameraError("camera_matrix must be fx skew cx, 0 fy cy, 0 0 1")
        if not abs(self.matrix[0, 1]) <= GREATEST_SKEW * self.matrix[0, 0]:
            raise CameraError(
                f"the skew in camera_matrix is {self.matrix[0, 1]:g} px; valid is up to "
                f"{GREATEST_SKEW:g} of the focal length: rows are fx skew cx, 0 fy cy, 0 0 1"
            )
        if not 0 <= self.readout < 1:
            raise CameraError(f"rolling_shutter_readout is {self.readout} s; valid is 0 to 1")


@dataclass(frozen=True, eq=False)
class FloorView:
    """A camera above the floor: which floor point each pixel sees, in the robot frame.

    Views of the same numbers are equal, so that tables made of them are made once.
    """

    lens: Lens
    robot_from_camera: Array = field(repr=False)
    """(4, 4) homogeneous transform; z = 0 of the robot frame is the floor."""

    def __eq__(self, other: object) -> bool:
        return isinstance(other, FloorView) and self._numbers == other._numbers

    def __hash__(self) -> int:
        return hash(self._numbers)

    @cached_property
    def _numbers(self) -> tuple[object, ...]:
        lens = self.lens
        arrays = (lens.matrix, lens.distortion, self.robot_from_camera)
        size = (lens.width, lens.height, lens.readout, lens.model)
        return (*size, *(array.tobytes() for array in arrays))

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
