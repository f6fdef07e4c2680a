"""What a robot saw on a drive, look by look: pictures of tape, or the scans of a laser."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np

from app.console import say
from app.lab.localize.reading.bag import Bag
from app.lab.localize.reading.carmen import is_carmen_log, measurements
from app.lab.localize.reading.layout import choose, find_layout
from app.lab.localize.reading.pairing import Measurement, Pairing, require_clock
from app.lab.mapping.command import read_drive
from app.recordings.attachments import SETTINGS
from app.recordings.files.mcap_reader import open_recording
from app.recordings.files.recorded import RecordingError
from robot.geometry import Pose2
from robot.mapping.grid.beams import Beams, of_pictures, steps_of
from robot.mapping.moving import moving
from robot.mapping.tape_map import MappingError

STEP_M, STEP_RAD = 0.3, 0.2
"""A laser's scan is used if the robot moved or turned at least this far since the last one."""
REACH_M = 20.0
"""Walls that are farther away are not drawn [m]: an error of the heading moves them too far."""


class Look(NamedTuple):
    """One scan or picture, and how the robot came there by odometry."""

    stamp: float
    moved: Pose2
    beams: Beams


def is_laser_bag(recording: Path) -> bool:
    """Return whether a recording is of another robot, with a laser, and not of ours."""
    if is_carmen_log(recording) or recording.suffix in (".bag", ".db3"):
        return True
    try:
        reader = open_recording(recording)
    except RecordingError:
        # A ROS 2 bag's folder may hold an SQLite database; the reader reports anything else.
        return recording.is_dir() and any(recording.glob("*.db3"))
    kinds = {kind.rpartition("/")[2] for kind in reader.topics.values()}
    return SETTINGS not in reader.attachments and kinds.isdisjoint({"Image", "CompressedImage"})


def pictures(parsed: argparse.Namespace) -> Iterator[Look]:
    """Return what a camera saw, at each picture that was taken while the robot moved.

    Raises:
        MappingError, RecordingError, OSError: says what cannot be used.
    """
    log, spec = read_drive(parsed.recording, parsed.width)
    if len(log.stamps) < 2:
        raise MappingError(f"{parsed.recording} has less than two pictures")
    log = log.some(moving(log, spec))
    steps = [Pose2(), *steps_of(log, spec)]
    return map(Look, log.stamps.tolist(), steps, of_pictures(log, spec))


def scans(parsed: argparse.Namespace) -> Iterator[Look]:
    """Yield what a laser saw, whenever the robot has moved some way.

    Raises:
        BagError, SettingError, OSError: says what cannot be used.
    """
    require_clock(parsed.clock)
    last: Pose2 | None = None
    newest, late = -np.inf, 0
    for odom_from_robot, scan in _measured(parsed):
        if scan.stamp <= newest:
            late += 1
            continue
        newest = scan.stamp
        moved = Pose2() if last is None else last.inverse() @ odom_from_robot
        near = np.hypot(moved.x, moved.y) < STEP_M and abs(moved.theta) < STEP_RAD
        if last is not None and near:
            continue
        last = odom_from_robot
        yield Look(scan.stamp, moved, Beams.of_scan(scan, REACH_M))
    if late:
        say(f"left out, as their stamps do not rise: {late} scans")


def _measured(parsed: argparse.Namespace) -> Iterator[Measurement]:
    if is_carmen_log(parsed.recording):
        yield from measurements(parsed.recording)
        return
    with Bag(parsed.recording) as bag:
        chosen = choose(bag, parsed.scan_topic, parsed.odom_topic)
        laser_pose = None if parsed.laser_pose is None else Pose2(*parsed.laser_pose)
        layout = find_layout(bag, chosen, laser_pose)
        say(f"{chosen.scan} and {chosen.odometry or 'tf'}, laser as told by {layout.told_by}")
        pairing = Pairing(bag, chosen, layout, parsed.clock)
        yield from pairing.measurements()
        for line in (*pairing.left_out.lines(), *bag.damages):
            say(line)
