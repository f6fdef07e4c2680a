"""Collects the ticks of a drive, and lets a process draw a map from them."""

from __future__ import annotations

from bisect import bisect_left
from concurrent.futures import Future
from copy import copy
from dataclasses import dataclass, replace

import numpy as np

from app.engine.program import Program
from app.engine.snapshot import Snapshot
from app.features.calibration.followed_drive import give_way, start_of
from app.worker_process import WorkerProcess
from robot.calibration.drive_log import DriveLog, DriveRecorder
from robot.description.spec import RobotSpec
from robot.fields.occupancy_grid import OccupancyGrid
from robot.geometry import Pose2, interpolate
from robot.mapping.mapper import Mapper
from robot.mapping.seen_floor import SeenFloor, occupancy
from robot.mapping.sketch import Sketch
from robot.mapping.tape_map import TapeMap
from robot.scanning.tape import Tape

FEWEST_EDGES = 4
"""A picture shows tape if at least this many rays met it."""
SHADES = {False: "dark", True: "light"}
"""Names of what a scanner searches for, by whether it is lighter than the floor."""


@dataclass(frozen=True)
class Drawn:
    """The result of one job."""

    sketch: Sketch
    grid: OccupancyGrid
    """The map as a grid of cells."""


@dataclass(frozen=True)
class Whole:
    """The map of the whole drive so far."""

    drawn: TapeMap
    grid: OccupancyGrid


@dataclass(frozen=True)
class Drawer:
    """The settings of a map."""

    spec: RobotSpec
    width: float
    """Width of the tape [m]."""
    start: Pose2
    side: float
    """Side of the cells [m]."""


class MappedDrive:
    """One drive from its first tick; used by one thread."""

    def __init__(self, program: Program, first: Snapshot, process: WorkerProcess) -> None:
        """Begin at the first tick, which is added later, and start the process that draws."""
        self._spec = first.spec
        scanner = program.engine.scanner
        width = scanner.main_width
        self._process = process
        give_way(process)
        shade = "either" if len(scanner.looks) > 1 else SHADES[scanner.looks[0].light]
        settings = replace(program.config.scanner, tape_brightness=shade, tape_width=width)
        self._recorder = DriveRecorder(self._spec, settings, (Tape(width),), calibrated=True)
        side = program.config.ros2.map_resolution
        process.submit(_begin, Drawer(self._spec, width, start_of(first), side))
        self._stamps: list[float] = []
        self._odometry: list[Pose2] = []
        self.began = first.stamp
        """Stamp of the first tick [s]."""
        self.seen = first.stamp
        """Stamp of the last picture that showed tape, or that was not examined [s]."""

    @property
    def seconds(self) -> float:
        """Its duration [s]."""
        return self._stamps[-1] - self.began

    def add(self, snapshot: Snapshot, *, look: bool = True) -> None:
        """Add a tick; if its picture is not examined, only its odometry counts."""
        edges = self._recorder.add(snapshot.reading, look=look)
        self._stamps.append(snapshot.stamp)
        self._odometry.append(snapshot.odom_from_robot)
        if edges is None:
            return
        if not look or np.isfinite(edges[:, 0]).sum() >= 2 * FEWEST_EDGES:
            self.seen = snapshot.stamp

    def draw(self) -> Future[Drawn | None]:
        """Let the process draw the new ticks; None if there are none.

        The future raises a MappingError while the drive shows too little, and a CalibrationError
        if no path explains it.
        """
        return self._process.submit(_draw, self._recorder.take())

    def whole(self) -> Future[Whole]:
        """Let the process adjust the whole drive so far; the future raises the errors of ``draw``.

        The drive may continue meanwhile.
        """
        return self._process.submit(_whole, self._recorder.take())

    def map_from_odom(self, pose: Pose2, stamp: float) -> Pose2:
        """Return the odom frame in a map, from the robot's pose at a picture's stamp [s]."""
        # A picture shows the floor at the moment of its exposure.
        exposed = stamp - self._spec.picture_delay
        later = min(max(1, bisect_left(self._stamps, exposed)), len(self._stamps) - 1)
        start, end = self._stamps[later - 1], self._stamps[later]
        fraction = min(max(0.0, (exposed - start) / (end - start)), 1.0)
        odometry = interpolate(self._odometry[later - 1], self._odometry[later], fraction)
        return pose @ odometry.inverse()


class _Growing:
    """The map in the process, which keeps it, so that only new ticks are sent."""

    def __init__(self, drawer: Drawer) -> None:
        self._drawer = drawer
        self._log: DriveLog | None = None
        self._mapper: Mapper | None = None

    def draw(self, more: DriveLog) -> Drawn | None:
        # If no path explains the new ticks, the map drawn before stays.
        mapper = copy(self._extended(more))
        before = mapper.mapped
        mapper.catch_up()
        sketch = mapper.sketch()
        if sketch is None or mapper.mapped == before:
            return None
        self._mapper = mapper
        drawer = self._drawer
        seen = SeenFloor.of(mapper.rays)
        return Drawn(sketch, occupancy(sketch.lines, drawer.width, seen, drawer.side))

    def whole(self, more: DriveLog) -> Whole:
        # An adjustment of the whole drive has other strokes than the growing map.
        drawn = copy(self._extended(more)).run()
        return Whole(drawn, drawn.cells(self._drawer.side))

    def _extended(self, more: DriveLog) -> Mapper:
        self._log = more if self._log is None else self._log.followed_by(more)
        if self._mapper is None:
            drawer = self._drawer
            self._mapper = Mapper(self._log, drawer.spec, drawer.width, drawer.start)
        else:
            self._mapper.extend(self._log)
        return self._mapper


_growing: _Growing
"""The map of this process; each process draws one."""


def _begin(drawer: Drawer) -> None:
    global _growing  # noqa: PLW0603 -- jobs of a process share nothing else
    _growing = _Growing(drawer)


def _draw(more: DriveLog) -> Drawn | None:
    return _growing.draw(more)


def _whole(more: DriveLog) -> Whole:
    return _growing.whole(more)
