"""Follows the robot's calibration while the engine runs, and gives what was learnt as commands."""

from __future__ import annotations

import math
from concurrent.futures import Future, ThreadPoolExecutor

import numpy as np

from app.engine.controls import Controls
from app.messages.commands import Command, SetCalibrationCommand, SetPoseCommand
from robot.calibration.drift import DriftFinding
from robot.calibration.tracker import CalibrationTracker, Update
from robot.geometry import Pose2
from robot.interface import Reading
from robot.localization.estimate import BOUNDED, KNOWN, Alert, Cause

PATIENCE_S = 0.5
"""A result is used this long after its work began [s], on the robot's clock, so that drives repeat
exactly, however fast the computer is. The engine waits only if the result is not there by then."""
NEAR = 0.02
"""The filter keeps its own pose if it is certain, and nearer than this to the tracker's [m]."""
CARRIED, CARRIED_TURN = 0.05, 0.5
"""Standard deviation of what odometry adds since then, as a share of it, and of its turn by its way
[rad/m]."""
SOURCE = "driving, as it was tracked"


class CalibrationTracking:
    """Runs a tracker beside the engine: its work is done in another thread."""

    def __init__(self, tracker: CalibrationTracker) -> None:
        self._tracker = tracker
        self._worker = ThreadPoolExecutor(1, "calibration")
        self._result: Future[DriftFinding | None] | None = None
        self._due = 0.0

    def add(self, reading: Reading, controls: Controls) -> None:
        """Add a reading after its picture was used, and begin work if there is any."""
        odometry, follower = controls.odom_from_scan, controls.follower
        pose = None
        if reading.frame is not None and odometry is not None and follower.belief is not None:
            known = follower.integrity_at(odometry).state in KNOWN
            pose = follower.belief.pose(odometry) if known else None
        self._tracker.add(reading, pose, odometry)
        if self._result is None and (job := self._tracker.job()) is not None:
            self._result = self._worker.submit(job)
            self._due = reading.stamp + PATIENCE_S

    def commands(self, odom_from_robot: Pose2, controls: Controls) -> tuple[Command, ...]:
        """Return what has to be done about the last result; nothing until it is due."""
        if not self._tracker.is_of(controls.spec):
            self._tracker.begin(controls.spec)
        if self._result is None or controls.stamp < self._due:
            return ()
        result, self._result = self._result.result(), None
        update = self._tracker.take(result)
        remark = self._tracker.remark
        controls.localization.remarks = (Alert(Cause.CAMERA_ASKEW, remark),) if remark else ()
        return () if update is None else _commands(update, odom_from_robot, controls)

    def close(self) -> None:
        """End the thread; work that has begun is finished first."""
        self._worker.shutdown()


def _commands(update: Update, odom_from_robot: Pose2, controls: Controls) -> tuple[Command, ...]:
    calibration = SetCalibrationCommand(
        type="set_calibration", values=update.values, sd=update.sd, source=SOURCE
    )
    moved = update.odom_from_robot.inverse() @ odom_from_robot
    pose = update.pose @ moved
    belief = controls.follower.belief
    known = controls.follower.integrity_at(odom_from_robot).state in BOUNDED
    if belief is not None and known and belief.pose(odom_from_robot).distance_to(pose) < NEAR:
        return (calibration,)
    way = math.hypot(moved.x, moved.y)
    added = CARRIED * way, CARRIED * way, CARRIED * abs(moved.theta) + CARRIED_TURN * way
    covariance = (update.covariance + np.diag(np.square(added))).reshape(-1).tolist()
    known_pose = SetPoseCommand(
        type="set_pose", x=pose.x, y=pose.y, theta=pose.theta, covariance=covariance
    )
    return calibration, known_pose
