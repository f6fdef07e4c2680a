"""What a robot saw on a drive, look by look: pictures of tape, or the scans of a laser."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np

from app.console import say
from app.features.lab.localize.reading.bag import Bag
from app.features.lab.localize.reading.bag_files import PACKED, files_of, require_bag
from app.features.lab.localize.reading.carmen import CarmenLog, is_carmen_log
from app.features.lab.localize.reading.lasers import Lasers, find_lasers
from app.features.lab.localize.reading.pairing import Measurement, require_clock
from app.features.lab.mapping.command import read_drive
from app.features.recordings.attachments import SETTINGS
from app.features.recordings.files.file_kinds import MCAP
from app.features.recordings.files.mcap_reader import open_recording
from app.features.recordings.files.recorded import CDR, ROS1, RecordingError
from robot.geometry import Pose2
from robot.mapping.grid.beams import Beams, of_pictures, steps_of
from robot.mapping.moving import moving
from robot.mapping.tape_map import MappingError

STEP_M, STEP_RAD = 0.3, 0.2
"""A laser's scan is used if the robot moved or turned at least this far since the last one."""
TOGETHER_S = 0.2
"""Scans of several lasers within this time make one look [s]."""
REACH_M = 20.0
"""Walls that are farther away are not drawn [m]: an error of the heading moves them too far."""


class Observation(NamedTuple):
    """One scan or picture, and how the robot came there by odometry."""

    stamp: float
    moved: Pose2
    beams: Beams
    begins: bool = False
    """Whether it is the first of another drive."""


def is_laser_bag(recording: Path) -> bool:
    """Return whether a recording is of another robot, with a laser, and not of ours.

    Raises:
        BagError, RecordingError: it is neither; says what it is, before any option is blamed.
    """
    if is_carmen_log(recording):
        return True
    try:
        reader = open_recording(recording, (CDR, ROS1))
    except RecordingError:
        if not recording.exists():
            return False  # its reader says so, once the options are known to be right
        # It may be of another kind than our own.
        others = [file for file in files_of(recording).paths if file.suffix != MCAP]
        if not others:
            raise
        for file in others:
            if file.suffix != PACKED:
                require_bag(file)
        return True
    kinds = {kind.rpartition("/")[2] for kind in reader.topics.values()}
    return SETTINGS not in reader.attachments and kinds.isdisjoint({"Image", "CompressedImage"})


def pictures(parsed: argparse.Namespace) -> Iterator[Observation]:
    """Return what a camera saw, at each picture that was taken while the robot moved.

    Raises:
        MappingError, RecordingError, OSError: says what cannot be used.
    """
    log, spec = read_drive(parsed.recording, parsed.width)
    if len(log.stamps) < 2:
        raise MappingError(f"{parsed.recording} has less than two pictures")
    log = log.some(moving(log, spec))
    steps = [Pose2(), *steps_of(log, spec)]
    return map(Observation, log.stamps.tolist(), steps, of_pictures(log, spec))


def scans(parsed: argparse.Namespace) -> Iterator[Observation]:
    """Yield what a laser saw, whenever the robot has moved some way.

    Raises:
        BagError, SettingError, OSError: says what cannot be used.
    """
    require_clock(parsed.clock)
    late = 0
    for drive in _drives(parsed):
        last: _Begun | None = None
        newest = -np.inf
        for measured in drive:
            stamp = measured.scan.stamp
            if stamp <= newest:
                late += 1
                continue
            newest = stamp
            if last is None or last.is_left(measured.odom_from_robot):
                if last is not None:
                    yield last.look
                last = _Begun(measured, last)
            else:
                last.join(measured)
        if last is not None:
            yield last.look
    if late:
        say(f"left out, as their stamps do not rise: {late} scans")


class _Begun:
    """A look whose scan is taken, and to which each other laser's next scan may be added."""

    def __init__(self, measured: Measurement, before: _Begun | None) -> None:
        pose, scan = measured
        self._pose, self._lasers = pose, {scan.robot_from_scan}
        moved = Pose2() if before is None else before._pose.inverse() @ pose
        self.look = Observation(scan.stamp, moved, Beams.of_scan(scan, REACH_M), before is None)

    def is_left(self, pose: Pose2) -> bool:
        """Whether the robot has come far enough for the next look."""
        moved = self._pose.inverse() @ pose
        return bool(np.hypot(moved.x, moved.y) >= STEP_M or abs(moved.theta) >= STEP_RAD)

    def join(self, measured: Measurement) -> None:
        """Add another laser's scan, seen from where the look is taken."""
        pose, scan = measured
        laser = scan.robot_from_scan
        if laser in self._lasers or scan.stamp - self.look.stamp > TOGETHER_S:
            return
        self._lasers.add(laser)
        beams = Beams.of_scan(scan, REACH_M).seen_from(self._pose.inverse() @ pose)
        self.look = self.look._replace(beams=self.look.beams.and_of(beams))


def _drives(parsed: argparse.Namespace) -> Iterator[Iterator[Measurement]]:
    """Yield the scans of each drive in a recording; all but the first are of logs."""
    if is_carmen_log(parsed.recording):
        log = CarmenLog(parsed.recording)
        yield from log.drives()
        for line in log.remarks:
            say(line)
        return
    with Bag(parsed.recording) as bag:
        lasers = find_lasers(bag, parsed)
        for line in (line for laser in lasers for line in laser.words):
            say(line)
        pairing = Lasers(bag, lasers, parsed.clock)
        yield pairing.measurements()
        for line in (*pairing.remarks, *pairing.left_out.lines(), *bag.damages):
            say(line)
