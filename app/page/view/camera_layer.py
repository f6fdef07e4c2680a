"""The camera in the 3D view: its newest picture in its frustum, and laid on the floor.

The picture lies where the robot believes it was taken: where its tape is not on the floor's, the
robot is wrong about its place, or the camera's calibration is.
"""

from __future__ import annotations

import math

import cv2
import numpy as np
import viser
from cv2.typing import MatLike
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from app.engine.snapshot import Snapshot
from robot.camera import FloorView
from robot.description.spec import RobotSpec
from robot.fields.floor_picture import FloorPicture
from robot.geometry import Array, Pose2
from robot.interface import Frame

COLOUR = (60, 70, 80)
FRUSTUM_M = 0.09
PICTURE_PX = (160, 120)
"""Size of the picture in the frustum."""
FARTHEST = 0.7
"""The picture is laid on the floor up to here from the robot's origin [m]: farther floor is blurred
by the camera's flat view."""
CELL = 0.004
"""Size of a pixel on the floor [m]."""
HEIGHT = 0.0008
"""Above the drawn floor, and below all that is drawn on it [m]."""


class CameraLayer:
    """A camera's frustum and its picture on the floor."""

    def __init__(self, scene: viser.SceneApi, spec: RobotSpec, drawn: FloorPicture) -> None:
        """Show a robot's camera on a floor, without a picture yet."""
        self._drawn = drawn
        self._frustum = scene.add_camera_frustum(
            "/robot/camera",
            fov=2 * math.atan(spec.lens.height / 2 / spec.lens.matrix[1, 1]),
            aspect=spec.lens.width / spec.lens.height,
            scale=FRUSTUM_M,
            thickness=0.001,
            color=COLOUR,
            format="jpeg",
            jpeg_quality=70,
            cast_shadow=False,
        )
        self._patch = FloorPatch.of(spec.floor_view)
        width, height = self._patch.size
        self._floor = scene.add_image(
            "/believed/picture",
            np.zeros((1, 1, 3), np.uint8),
            width,
            height,
            format="jpeg",
            jpeg_quality=70,
            cast_shadow=False,
            receive_shadow=False,
        )
        self._pictured: Frame | None = None
        self.use_robot(spec)

    def use_robot(self, spec: RobotSpec) -> None:
        """Show a robot as a calibration knows it."""
        self._frustum.wxyz = _turn(spec)
        self._frustum.position = tuple(spec.robot_from_camera[:3, 3])
        self._patch = FloorPatch.of(spec.floor_view)
        self._floor.render_width, self._floor.render_height = self._patch.size

    def show(self, visible: bool) -> None:
        """Show or hide it."""
        self._frustum.visible = self._floor.visible = visible

    def place(self, snapshot: Snapshot) -> None:
        """Lay the picture where it was taken, as the robot moves on."""
        if snapshot.pose is None or snapshot.scan_pose is None:
            return
        now_from_scan = snapshot.pose.inverse() @ snapshot.scan_pose
        middle = now_from_scan.apply(self._patch.middle[None])[0]
        self._floor.position = (middle[0], middle[1], HEIGHT)
        half = now_from_scan.theta / 2
        self._floor.wxyz = (math.cos(half), 0.0, 0.0, math.sin(half))

    def picture(self, snapshot: Snapshot) -> None:
        """Show the newest picture."""
        frame = snapshot.frame
        if frame is None or frame is self._pictured:
            return
        self._pictured = frame
        small = cv2.resize(frame.image, PICTURE_PX, interpolation=cv2.INTER_AREA)
        self._frustum.image = _colours(small)
        if snapshot.scan_pose is not None:
            self._floor.image = self._patch.picture(frame.image, snapshot.scan_pose, self._drawn)


class FloorPatch:
    """The part of the floor that a camera sees, and where in the picture each point of it is."""

    def __init__(self, view: FloorView, low: Array, high: Array) -> None:
        """Prepare for a view and a rectangle of the robot frame [m]."""
        x, y = (np.arange(a, b, CELL) + CELL / 2 for a, b in zip(low, high, strict=True))
        points = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
        pixels = view.pixels(points)
        self.middle = np.array([x.mean(), y.mean()])
        """(2,) [m]"""
        self.size = (len(x) * CELL, len(y) * CELL)
        """Ahead and across [m]."""
        shape = (len(y), len(x))
        near = np.hypot(*points.T) < FARTHEST
        self._robot_from_patch = np.array([[CELL, 0, x[0]], [0, CELL, y[0]], [0, 0, 1]])
        self._inside = (near & view.inside(pixels)).reshape(shape)
        u, v = np.nan_to_num(pixels, nan=-1).astype(np.float32).T
        self._pixels = u.reshape(shape), v.reshape(shape)

    @classmethod
    def of(cls, view: FloorView) -> FloorPatch:
        """Return the part of the floor that all of the picture sees, up to ``FARTHEST``."""
        u, v = np.meshgrid(np.linspace(0, view.lens.width - 1, 9), np.arange(view.lens.height))
        floor = view.floor_points(np.column_stack([u.ravel(), v.ravel()]).astype(float))
        near = floor[np.hypot(*floor.T) < FARTHEST]
        if not len(near):  # it looks at no floor
            near = np.array([[0.1, -0.1], [0.2, 0.1]])
        return cls(view, near.min(axis=0), near.max(axis=0) + CELL)

    def picture(
        self, image: NDArray[np.uint8], map_from_robot: Pose2, drawn: FloorPicture
    ) -> NDArray[np.uint8]:
        """Return an image as seen from above (rows across, columns ahead, 3).

        What it does not show is as drawn: viser's pictures are rectangles without holes.
        """
        flat = cv2.remap(image, *self._pixels, cv2.INTER_LINEAR)
        rest = cv2.warpAffine(
            drawn.image,
            self._drawn_from_patch(map_from_robot, drawn),
            self._inside.shape[::-1],
            flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP,
            borderMode=cv2.BORDER_CONSTANT,
            borderValue=drawn.border,
        )
        return np.where(self._inside[:, :, None], _colours(flat), _colours(rest))

    def _drawn_from_patch(self, map_from_robot: Pose2, drawn: FloorPicture) -> Array:
        c, s = math.cos(map_from_robot.theta), math.sin(map_from_robot.theta)
        turned = np.array([[c, -s, map_from_robot.x], [s, c, map_from_robot.y], [0, 0, 1]])
        transform: Array = drawn.pixel_from_map @ turned @ self._robot_from_patch
        return transform


def _colours(image: MatLike) -> NDArray[np.uint8]:
    """Return a picture in grey, or in OpenCV's order of colours, as red, green and blue."""
    pixels = np.asarray(image, np.uint8)
    return pixels[:, :, ::-1] if pixels.ndim == 3 else np.repeat(pixels[:, :, None], 3, axis=2)


def _turn(spec: RobotSpec) -> tuple[float, float, float, float]:
    """Return the quaternion of the camera in the robot frame, as w, x, y, z."""
    x, y, z, w = Rotation.from_matrix(spec.robot_from_camera[:3, :3]).as_quat().tolist()
    return w, x, y, z
