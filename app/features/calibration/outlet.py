"""The outlet of calibrations: it measures the robot as it was built, and its lens."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from datetime import UTC, datetime
from typing import Any

from fastapi import APIRouter

from app.engine.snapshot import Snapshot
from app.features.calibration.commands import CALIBRATOR
from app.features.calibration.drive_calibrator import DriveCalibrator
from app.features.calibration.floor_grid import floor_grid_router
from app.features.calibration.lens.routes import lens_router
from app.features.calibration.routes import calibration_router, drive_message
from app.page.outlets import Outlet, Outlets


class CalibrationOutlet(Outlet):
    """The calibration of one program's robot."""

    def __init__(self, outlets: Outlets) -> None:
        """Prepare to measure."""
        self._program = outlets.program
        self.calibrator = DriveCalibrator(outlets.program, lambda: datetime.now(UTC))

    @property
    def parts(self) -> Mapping[str, object]:
        """What collects a drive, and adjusts the robot to it."""
        return {CALIBRATOR.name: self.calibrator}

    def routers(self) -> Iterable[APIRouter]:
        """Return the routes of the drive, of the floor's grid, and of the lens page."""
        program = self._program
        return (
            floor_grid_router(program),
            lens_router(program),
            calibration_router(program, self.calibrator),
        )

    def telemetry(self, snapshot: Snapshot) -> Mapping[str, Any]:
        """Return how far the drive is."""
        return {"calibration": drive_message(self.calibrator.drive, snapshot.stamp)}

    def close(self) -> None:
        """End the work on a drive."""
        self.calibrator.close()
