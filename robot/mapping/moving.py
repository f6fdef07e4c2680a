"""Chooses the pictures that a map is drawn from: one for each step that the robot has moved."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from robot.calibration.drive_log import DriveLog
from robot.calibration.wheel_motion import WheelMotion
from robot.description.spec import RobotSpec
from robot.description.unknowns import COUNT

STEP_M, STEP_RAD = 0.02, 0.05
"""A picture is used if the robot moved or turned at least this far since the last one."""


def moving(log: DriveLog, spec: RobotSpec) -> NDArray[np.intp]:
    """Return which pictures are used: the robot has moved since the last one."""
    steps, _ = WheelMotion.of(log, spec).steps(np.zeros(COUNT), np.zeros((len(log.stamps) - 1, 2)))
    kept, way, turn = [0], 0.0, 0.0
    for k, step in enumerate(steps, start=1):
        way, turn = way + float(np.hypot(step[0], step[1])), turn + abs(float(step[2]))
        if way >= STEP_M or turn >= STEP_RAD:
            kept.append(k)
            way = turn = 0.0
    return np.array(kept)
