"""What the program asks of any camera."""

from __future__ import annotations

from typing import Protocol, runtime_checkable

from robot.interface import Frame


class PictureError(RuntimeError):
    """No picture can be had at the moment; the message says why, and the cure."""


@runtime_checkable
class Camera(Protocol):
    """Something that takes pictures by itself, of which the newest can be asked for."""

    @property
    def name(self) -> str:
        """What to call it in a message."""
        ...

    def newest(self) -> Frame | None:
        """The newest picture, if it was not handed out before; never waits.

        Its stamp is the middle of the exposure of the middle row on the clock of
        ``time.monotonic`` [s], and its size is that of the lens.
        """
        ...

    @property
    def problem(self) -> str | None:
        """Why no pictures come, with the cure; None while they come."""
        ...

    def close(self) -> None:
        """Let go of the camera; may be called twice."""
        ...
