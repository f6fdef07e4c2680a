"""Collects the ticks of a calibration's drive, for its adjustment."""

from __future__ import annotations

import math
from concurrent.futures import Future
from dataclasses import dataclass

import numpy as np

from app.engine.program import Program
from app.engine.snapshot import Snapshot
from app.features.calibration.followed_drive import give_way, start_of
from app.messages.commands import SetPoseCommand
from app.worker_process import WorkerProcess
from robot.calibration.calibrate import START_COVARIANCE, Calibration, calibrate
from robot.calibration.drive_log import DriveLog, DriveRecorder
from robot.description.spec import RobotSpec
from robot.fields.field import Field
from robot.geometry import Pose2

STANDING_SD = np.array([0.002, 0.002, math.radians(0.5)])
"""How far a robot that stands may have moved unnoticed while its drive is adjusted [m, m, rad]."""


@dataclass(frozen=True)
class _Job:
    """The input of the process that adjusts."""

    log: DriveLog
    spec: RobotSpec
    field: Field
    start: Pose2


class CollectedDrive:
    """One drive from its first tick; used by one thread."""

    def __init__(self, program: Program, first: Snapshot, process: WorkerProcess) -> None:
        """Begin with the first tick, and start the process that will adjust the drive."""
        self.spec = first.spec.uncalibrated
        """The robot as it would be without a calibration."""
        self._field = program.field
        self._process = process
        # It loads its modules while the robot drives.
        give_way(process)
        self._recorder = DriveRecorder(self.spec, program.config.scanner, program.field.tape)
        self._start = start_of(first)
        self.began = first.stamp
        """Stamp of the first tick [s]."""
        self._last = first
        self.add(first)

    @property
    def seconds(self) -> float:
        """Its duration [s]."""
        return self._last.stamp - self.began

    def add(self, snapshot: Snapshot) -> None:
        """Add a tick."""
        self._recorder.add(snapshot.reading)
        self._last = snapshot

    def adjusted(self) -> Future[Calibration]:
        """Let the process adjust the ticks collected so far.

        The future raises a CalibrationError if the drive does not determine the unknowns.
        """
        job = _Job(self._recorder.log, self.spec, self._field, self._start)
        return self._process.submit(_calibrate, job)

    def pose_command(self, calibration: Calibration, newest: Snapshot) -> SetPoseCommand:
        """Return the command that gives the filter the pose of the robot.

        Args:
            calibration: the result of the whole drive.
            newest: a tick after the drive; the robot stands since the drive ended.
        """
        solution = calibration.solution
        moved = self._last.odom_from_robot.inverse() @ newest.odom_from_robot
        pose = Pose2(*solution.state.poses[-1].tolist()) @ moved
        sd = np.maximum(np.sqrt(np.diag(solution.pose_covariance)), STANDING_SD)
        return SetPoseCommand(
            type="set_pose",
            x=pose.x,
            y=pose.y,
            theta=pose.theta,
            sd_xy=float(sd[:2].max()),
            sd_theta=float(sd[2]),
        )


def _calibrate(job: _Job) -> Calibration:
    return calibrate(job.log, job.spec, job.field, job.start, START_COVARIANCE)
