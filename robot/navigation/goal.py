"""Goal: where a robot shall go."""

from __future__ import annotations

from typing import NamedTuple


class Goal(NamedTuple):
    """A place in the map, and the heading there; None is any."""

    x: float
    y: float
    theta: float | None = None
