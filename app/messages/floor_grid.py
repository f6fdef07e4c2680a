"""The message of ``/api/floor-grid``."""

from __future__ import annotations

from app.messages.message import Message


class GridLineMessage(Message):
    """A part of a line on the floor that the picture shows."""

    pixels: list[tuple[float, float]]
    """Along it (u, v) [px]."""
    ahead: bool
    """Whether it is the line straight ahead of the robot."""


class GridLabelMessage(Message):
    """A distance ahead of the robot's axle, on the line straight ahead."""

    distance: float
    """[m]"""
    u: float
    v: float
    """Where it is in the picture [px]."""


class FloorGridMessage(Message):
    """The floor's grid, every 0.1 m, as the camera sees it."""

    lines: list[GridLineMessage]
    labels: list[GridLabelMessage]
