"""The ticks of a drive that a map is drawn from, and the jobs that draw it."""

from __future__ import annotations

from bisect import bisect_left
from concurrent.futures import Future
from dataclasses import dataclass

import numpy as np

from app.engine.followed_drive import give_way, start_of
from app.engine.program import Program
from app.engine.snapshot import Snapshot
from app.worker_process import WorkerProcess
from robot.calibration.drive_log import DriveLog, DriveRecorder
from robot.description.spec import RobotSpec
from robot.geometry import Pose2, interpolate
from robot.mapping.mapper import Mapper
from robot.mapping.sketch import Sketch
from robot.mapping.tape_map import TapeMap
from robot.scanning.tape import Tape

FEWEST_EDGES = 4
"""A picture shows tape if so many rays met it."""


@dataclass(frozen=True)
class Drawn:
    """What one job has drawn."""

    mapper: Mapper
    """To go on from."""
    sketch: Sketch | None


@dataclass(frozen=True)
class _Job:
    """What the process needs."""

    mapper: Mapper | None
    log: DriveLog
    spec: RobotSpec
    width: float
    start: Pose2

    def extended(self) -> Mapper:
        """Return the mapper with the whole drive."""
        if self.mapper is None:
            return Mapper(self.log, self.spec, self.width, self.start)
        self.mapper.extend(self.log)
        return self.mapper


class MappedDrive:
    """One drive, from its first tick on; for one thread."""

    def __init__(self, program: Program, first: Snapshot, process: WorkerProcess) -> None:
        """Begin with the first tick; a process will draw."""
        self._spec = first.spec
        self._width = program.engine.localization.scanner.main_width
        self._process = process
        give_way(process)
        self._recorder = DriveRecorder(
            self._spec, program.config.scanner, (Tape(self._width),), calibrated=True
        )
        self._start = start_of(first)
        self._mapper: Mapper | None = None
        self._stamps: list[float] = []
        self._odometry: list[Pose2] = []
        self.began = first.stamp
        """Stamp of the first tick [s]."""
        self.seen = first.stamp
        """Stamp of the last picture that showed tape [s]."""
        self.add(first)

    @property
    def seconds(self) -> float:
        """Its duration [s]."""
        return self._stamps[-1] - self.began

    def add(self, snapshot: Snapshot) -> None:
        """Add a tick."""
        edges = self._recorder.add(snapshot.reading)
        self._stamps.append(snapshot.stamp)
        self._odometry.append(snapshot.odom_from_robot)
        if edges is not None and np.isfinite(edges[:, 0]).sum() >= 2 * FEWEST_EDGES:
            self.seen = snapshot.stamp

    def draw(self) -> Future[Drawn]:
        """Let the process draw what is new.

        The future raises a MappingError while the drive shows too little, and a CalibrationError
        if no path explains it.
        """
        return self._process.submit(_draw, self._job())

    def keep(self, drawn: Drawn) -> Pose2 | None:
        """Go on from what a job has drawn; return where odometry began in that map."""
        self._mapper = drawn.mapper
        sketch = drawn.sketch
        return None if sketch is None else self._map_from_odom(sketch.pose, sketch.stamp)

    def finish(self) -> Future[TapeMap]:
        """Let the process adjust all of it; the future raises what those of ``draw`` raise."""
        return self._process.submit(_finish, self._job())

    def map_from_odom(self, drawn: TapeMap) -> Pose2:
        """Return where odometry began in a map."""
        last = Pose2.from_array(drawn.solution.state.poses[-1])
        return self._map_from_odom(last, float(drawn.stamps[-1]))

    def _map_from_odom(self, pose: Pose2, stamp: float) -> Pose2:
        # A picture shows the floor as it was when it was exposed.
        exposed = stamp - self._spec.picture_delay
        later = min(max(1, bisect_left(self._stamps, exposed)), len(self._stamps) - 1)
        start, end = self._stamps[later - 1], self._stamps[later]
        fraction = min(max(0.0, (exposed - start) / (end - start)), 1.0)
        odometry = interpolate(self._odometry[later - 1], self._odometry[later], fraction)
        return pose @ odometry.inverse()

    def _job(self) -> _Job:
        return _Job(self._mapper, self._recorder.log, self._spec, self._width, self._start)


def _draw(job: _Job) -> Drawn:
    mapper = job.extended()
    mapper.catch_up()
    return Drawn(mapper, mapper.sketch())


def _finish(job: _Job) -> TapeMap:
    return job.extended().run()
