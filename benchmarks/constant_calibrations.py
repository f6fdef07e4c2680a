"""Trials of a constant of calibration: robots that were built by hand calibrate themselves.

A map is drawn as well, as it is adjusted by the same least squares.
"""

from __future__ import annotations

import pickle
import zlib
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.constant_maps import (
    DRAWN,
    FAILED,
    AdjustedDrive,
    LoggedDrive,
    draw_map,
    driven,
    lap,
    over,
)
from robot.calibration.adjustment import CalibrationError
from robot.calibration.calibrate import START_COVARIANCE, calibrate
from robot.calibration.programme import velocity
from robot.description.spec import RobotSpec
from robot.description.unknowns import ROBOT
from robot.geometry import Pose2
from robot.mapping.tape_map import MappingError

FLOOR = "square"
CALIBRATED = (60203, 60204)
"""Seeds of the robots."""
CALIBRATION_S = 30.0
PLACED = Pose2(0.02, -0.02, 0.06)
"""How far off the start of a calibration is told."""


def recorded(kept: Path | None, seed: int = 0) -> list[LoggedDrive]:
    """Return all drives; from a file, or to it if it is not there yet."""
    if kept is not None and kept.exists():
        drives: list[LoggedDrive] = pickle.loads(kept.read_bytes())  # our own, of a minute ago
        return drives
    name, number = DRAWN[0]
    drives = [_calibrating(seed + number) for number in CALIBRATED] + [lap(name, seed + number)]
    if kept is not None:
        kept.write_bytes(pickle.dumps(drives))
    return drives


def few(drives: list[LoggedDrive]) -> list[LoggedDrive]:
    """Return all: they are few."""
    return drives


def _calibrating(seed: int) -> LoggedDrive:
    return driven("hand-built", FLOOR, seed, CALIBRATION_S, velocity)


def tried(drives: list[LoggedDrive], other_numbers: int) -> dict[str, Any]:
    """Calibrate, and draw the map; return figures by name, and a number for each result.

    Args:
        other_numbers: if not 0, added to the seeds of other drives.
    """
    results = []
    for drive in recorded(None, other_numbers) if other_numbers else drives:
        try:
            results.append(_calibrated(drive) if drive.name == FLOOR else draw_map(drive))
        except (MappingError, CalibrationError):
            results.append(FAILED)
    paths, medians, most = np.array([each.figures for each in results[: len(CALIBRATED)]]).T
    means, largest, missing = results[-1].figures
    return {
        "calibrated path off [mm]": over(np.mean, paths),
        "unknowns off, median [sd]": over(np.mean, medians),
        "at most [sd]": over(np.max, most),
        "map's edges off [mm]": means,
        "at most [mm]": largest,
        "not drawn [%]": missing,
        "refused": results.count(FAILED),
        "each": [result.number for result in results],
    }


def _calibrated(drive: LoggedDrive) -> AdjustedDrive:
    """Calibrate; the path's error [mm], and the unknowns' median and largest error by their sd."""
    start = Pose2.from_array(drive.path[0]) @ PLACED
    calibrated = calibrate(drive.log, RobotSpec.load(), drive.field, start, START_COVARIANCE)
    away = np.hypot(*(calibrated.solution.state.poses - drive.path)[:, :2].T)
    errors = np.abs(calibrated.values[:ROBOT] - drive.values[:ROBOT]) / calibrated.sd[:ROBOT]
    path = 1e3 * float(np.sqrt(np.mean(away**2)))
    figures = path, float(np.median(errors)), float(errors.max())
    return AdjustedDrive(figures, zlib.crc32(calibrated.values.tobytes()))
