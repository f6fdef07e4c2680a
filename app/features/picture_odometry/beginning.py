"""Begins to measure motion in pictures, where the settings want it; else nothing is loaded."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from app.settings.config import Config
from robot.fields.field import Field
from robot.interface import Robot
from robot.picture_odometry.settings import NAME, PictureOdometrySettings

if TYPE_CHECKING:
    from app.features.picture_odometry.companion import PictureOdometryCompanion


def companions(config: Config, robot: Robot, field: Field) -> Iterable[PictureOdometryCompanion]:
    """Return what measures motion in a new engine, if the settings want it."""
    settings = config.group(NAME, PictureOdometrySettings())
    if settings.enabled or settings.fuse:
        from app.features.picture_odometry.companion import (  # noqa: PLC0415 - most never want it
            PictureOdometryCompanion,
        )

        yield PictureOdometryCompanion(settings)
