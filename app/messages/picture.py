"""Messages of ``/api/camera``: a picture, and what the scanner found in it."""

from __future__ import annotations

from typing import Literal

from app.messages.message import Message


class EdgesMessage(Message):
    """Where the scanner found tape in a picture."""

    entry_px: list[tuple[float, float] | None]
    """Pixel (u, v) where each ray enters the tape; null for a ray that did not count."""
    exit_px: list[tuple[float, float] | None]
    tape_width: float | None
    """Median width measured over the rays that counted [m]."""


class PictureMessage(Message):
    """Head of each binary message of ``/api/camera``.

    The message is the head's length in bytes (uint32, little-endian), the head as JSON, and the
    picture as JPEG.
    """

    type: Literal["picture"] = "picture"
    stamp: float
    """Exposure [s]."""
    edges: EdgesMessage | None
    """What the scanner found in this very picture; null if it was not scanned."""
