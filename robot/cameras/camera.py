"""The interface that every camera implements."""

from __future__ import annotations

from typing import Protocol, runtime_checkable

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
