"""The guests of ROS: Foxglove, whose page comes from a site of its own."""

from __future__ import annotations

from collections.abc import Iterator

from app.feature import Guest
from app.settings.config import Config

FOXGLOVE = Guest("Foxglove", "/foxglove")


def guests(config: Config) -> Iterator[Guest]:
    """Yield Foxglove, if the settings ask for it."""
    if config.ros2.foxglove:
        yield FOXGLOVE
