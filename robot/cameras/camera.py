"""The interface that every camera implements; check and rotation of its pictures."""

from __future__ import annotations

from typing import Any, Protocol, runtime_checkable

import cv2
import numpy as np
from numpy.typing import NDArray

from robot.camera import Lens
from robot.errors import BrickPoseError
from robot.interface import Frame


class PictureError(BrickPoseError, RuntimeError):
    """No picture is available at the moment; the message says why, and the cure."""


class SourceError(BrickPoseError, ValueError):
    """No camera can have this name; the message says what is valid."""


@runtime_checkable
class Camera(Protocol):
    """A camera that takes pictures by itself and hands out the newest."""

    @property
    def name(self) -> str:
        """Name of the camera in messages."""
        ...

    def newest(self) -> Frame | None:
        """Return the newest picture, or None if it was handed out before; do not wait.

        Its stamp is the middle of the exposure of the middle row on the clock of
        ``time.monotonic`` [s]. Its size is that of the lens.
        """
        ...

    @property
    def problem(self) -> str | None:
        """Why no pictures come, with the cure; None while they come."""
        ...

    def close(self) -> None:
        """Release the camera; may be called twice."""
        ...


Picture = NDArray[np.uint8]
"""(h, w) grey or (h, w, 3) BGR."""


def check_size(shape: tuple[int, ...], lens: Lens, name: str) -> None:
    """Refuse a picture (h, w) or (h, w, 3) whose size is not the size in the lens description.

    It is not scaled: a camera that gives another size often sees another part of the floor.

    Raises:
        PictureError: the sizes differ; the message names both.
    """
    if tuple(shape[:2]) != (lens.height, lens.width):
        raise PictureError(
            f"{name} gives pictures of {shape[1]} x {shape[0]} px, but the lens is described for "
            f"{lens.width} x {lens.height} px: set the camera to that size, or calibrate it at "
            "its own and describe that lens in the robot's camera_info file"
        )


def upright(picture: Any, rotation: int) -> Picture:
    """Return a picture turned by 0 or 180 degrees."""
    if rotation:
        picture = cv2.rotate(picture, cv2.ROTATE_180)
    return np.asarray(picture, dtype=np.uint8)
