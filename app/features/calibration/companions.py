"""What goes along with an engine: ``trackings``, if the settings want the calibration tracked."""

from __future__ import annotations

from typing import TYPE_CHECKING

from app.settings.config import Config
from robot.fields.field import Field
from robot.interface import Robot

if TYPE_CHECKING:
    from app.features.calibration.tracking import CalibrationTracking

NAME = "calibration"


def trackings(config: Config, robot: Robot, field: Field) -> tuple[CalibrationTracking, ...]:
    """Return what tracks the robot of a new engine; nothing if the settings do not want it."""
    if NAME not in config.added:
        return ()
    # Few want it.
    from app.features.calibration.settings import CalibrationSettings  # noqa: PLC0415

    if not config.group(NAME, CalibrationSettings()).track:
        return ()
    from app.features.calibration.tracking import CalibrationTracking  # noqa: PLC0415
    from robot.calibration.tracker import CalibrationTracker  # noqa: PLC0415

    return (CalibrationTracking(CalibrationTracker(robot.spec, field, config.scanner)),)
