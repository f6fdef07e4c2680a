"""Drives that integrity is judged by: laps from anywhere, and a drive with a kidnapping."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from app.lab.evaluation.drives import Drive, record
from app.lab.evaluation.integrity.course import course_on
from app.settings.config import MAPS, Config
from robot.fields.field_loading import load_field

CARRY_STAMP, CARRY_SECONDS = 11.0, 17.0
"""Stamp at which a robot is carried off, and duration of that drive [s]."""
PATH = 7
"""Number of the random stream, beside the seed, that the path is drawn from."""


@dataclass(frozen=True)
class TrialDrive:
    """A drive, and when the robot was carried off."""

    drive: Drive
    carry_stamp: float | None = None
    """The last stamp before the robot is carried off [s]; None if it never is."""


def lap_drive(config: Config, laps: float = 1.0) -> TrialDrive:
    """Drive the figure-eight that fits the field, from a random pose on it.

    Args:
        config: robot, map, seed and condition; the radius of its figure-eight is not used.
        laps: how many laps to drive.
    """
    course = course_on(load_field(config.map, MAPS), config)
    config = replace(config, figure_eight=course.eight)
    rng = np.random.default_rng([config.seed, PATH])
    elapsed = float(rng.uniform(0, course.eight.lap))
    start = course.pose(rng, elapsed)
    drive = record(config, laps * course.eight.lap, start=start, elapsed=elapsed)
    return TrialDrive(drive)


def carried_drive(config: Config) -> TrialDrive:
    """Drive for 17 s; at 11 s the robot is carried off, unseen, to another path of the field."""
    course = course_on(load_field(config.map, MAPS), config)
    config = replace(config, figure_eight=course.eight)
    rng = np.random.default_rng([config.seed, PATH])
    elapsed = float(rng.uniform(0, course.eight.lap))
    start, elsewhere = course.pose(rng, elapsed), course.pose(rng, elapsed + CARRY_STAMP)
    drive = record(
        config, CARRY_SECONDS, start=start, elapsed=elapsed, kidnap=(CARRY_STAMP, elsewhere)
    )
    return TrialDrive(drive, CARRY_STAMP)
