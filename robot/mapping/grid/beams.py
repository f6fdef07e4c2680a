"""What one look at the floor or the room tells: beams that are free until they meet something."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from robot.calibration.adjustment import DriveEstimate
from robot.calibration.drive_log import DriveLog
from robot.calibration.wheel_motion import WheelMotion
from robot.description.spec import RobotSpec
from robot.description.unknowns import COUNT
from robot.geometry import Array, Pose2
from robot.mapping.ends import RaysOnFloor
from robot.scan import Scan


@dataclass(frozen=True, eq=False)
class Beams:
    """The beams of one scan or picture; points (n, 2) in the robot's frame [m]."""

    begin: Array
    end: Array
    """The beam is free until here."""
    beyond: Array
    """What it met reaches at least to here; the same as its end if that is not known."""
    hit: NDArray[np.bool_]
    """(n,) which of them met something."""

    @classmethod
    def of_scan(cls, scan: Scan, reach: float) -> Beams:
        """Return the beams of a laser, which sees a wall up to a distance [m].

        A beam without a return tells nothing: it may have met glass, or something black.
        """
        hit = scan.hit & (scan.ranges <= reach)
        ends = scan.within(0.0, reach).points()
        begin = np.tile(scan.robot_from_scan.to_array()[:2], (int(hit.sum()), 1))
        return cls(begin, ends, ends, np.ones(len(ends), bool))

    def seen_from(self, place: Pose2) -> Beams:
        """Return the same beams in the frame in which their robot is at a place."""
        begin, end, beyond = (place.apply(ends) for ends in (self.begin, self.end, self.beyond))
        return Beams(begin, end, beyond, self.hit)

    def and_of(self, other: Beams) -> Beams:
        """Return these beams and others of the same frame as one look."""
        return Beams(
            np.concatenate([self.begin, other.begin]),
            np.concatenate([self.end, other.end]),
            np.concatenate([self.beyond, other.beyond]),
            np.concatenate([self.hit, other.hit]),
        )


def of_pictures(log: DriveLog, spec: RobotSpec) -> list[Beams]:
    """Return the beams of each picture of a drive: where rays enter tape, and leave it."""
    count = len(log.stamps)
    still = DriveEstimate(np.zeros(COUNT), np.zeros((count, 3)), np.zeros((count, 2)))
    rays = RaysOnFloor.of(log, spec, still)
    hit = np.isfinite(rays.entry[:, 0]) & np.isfinite(rays.leaving[:, 0])
    met = np.isfinite(rays.first)
    end = np.where(hit[:, None], rays.entry, np.where(met, rays.first, rays.end))
    beyond = np.where(hit[:, None], rays.leaving, end)
    known = np.isfinite(rays.begin[:, 0]) & np.isfinite(end[:, 0])
    borders = np.searchsorted(rays.picture, np.arange(count + 1))
    return [
        Beams(rays.begin[some], end[some], beyond[some], hit[some])
        for low, high in pairwise(borders)
        for some in [low + np.flatnonzero(known[low:high])]
    ]


def steps_of(log: DriveLog, spec: RobotSpec) -> list[Pose2]:
    """Return the motion by the wheels from each picture of a drive to the next."""
    motion = WheelMotion.of(log, spec)
    steps, _ = motion.steps(np.zeros(COUNT), np.zeros((len(log.stamps) - 1, 2)))
    return [Pose2(*step) for step in steps.tolist()]
