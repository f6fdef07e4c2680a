"""Calibrates a robot by a drive on a known field."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from robot.calibration.adjustment import CalibrationError, Solution, Weights, quality_of
from robot.calibration.drive_log import DriveLog
from robot.calibration.drive_path import (
    BEGINNING_S,
    WINDOWS,
    DrivePath,
    FieldDrive,
    begin,
    start_text,
)
from robot.calibration.position_error import position_sd
from robot.calibration.start_poses import alike
from robot.description.spec import RobotSpec
from robot.description.unknowns import NAMES, PRIORS, ROBOT, ROTATION, SHIFT
from robot.estimation.fit_quality import FitQuality
from robot.fields.field import Field
from robot.geometry import Array, Pose2

START_COVARIANCE = np.diag(np.square([0.05, 0.05, math.radians(10)]))
"""How accurately people place a robot [m, m, rad]."""
SHORTEST_S = 5.0
"""Shortest drive that is adjusted [s]."""

LEARNT, UNTOLD = 0.5, 0.9
"""An unknown is learnt if its standard deviation is below the first share of the prior's. Above the
second share, the drive says nothing about it, and it stays as described. In between, it is
adjusted, but not reported as learnt."""

MOTIONS = {
    "drive straight ahead, toward tape and away from it": frozenset(
        ("camera_yaw", "left_radius", "right_radius")
    ),
    "turn on the spot, both ways, with tape in sight": frozenset(
        ("wheel_separation", "camera_x", "camera_y")
    ),
    "start and stop often": frozenset(("picture_delay",)),
    "look at tape both near and far, ahead and aside": frozenset(
        ("camera_roll", "camera_pitch", "camera_z", "focal_length")
    ),
}
"""Motions, and the unknowns that each determines best."""
FIXED = 1e-3
"""Factor on the prior of an unknown that stays as described."""

Report = Callable[[float, Solution], None]
"""Is called after each window with its length [s] and its solution."""


@dataclass(frozen=True, eq=False)
class Calibration:
    """The result of a calibration."""

    values: Array
    """(15,) differences from the description, in the order of ``UNKNOWNS``; zero if not learnt."""
    sd: Array = field(repr=False)
    """(15,) their standard deviations; that of the prior if not learnt."""
    solution: Solution = field(repr=False)
    quality: FitQuality
    """How well the drive fits."""
    doubts: tuple[str, ...] = ()
    """What seems to be wrong with the field or the lens file, as text."""

    @property
    def remarks(self) -> tuple[str, ...]:
        """What is to be known of the result, as text: contradictions first."""
        return (*self.quality.remarks, *self.doubts)

    @property
    def position_sd(self) -> float:
        """Standard deviation of the camera's apparent place, from what is still unknown [m]."""
        covariance = self.solution.covariance.copy()
        spread = np.diag_indices(len(covariance))
        # An unknown that stayed as described is as uncertain as before.
        covariance[spread] = np.maximum(covariance[spread], np.square(self.sd))
        return position_sd(self.solution.misses, covariance)

    @property
    def camera_y_sd(self) -> float:
        """Standard deviation of the camera's place across the robot [m], which decides."""
        return float(self.sd[SHIFT][1])

    @property
    def advice(self) -> tuple[str, ...]:
        """The motions that would determine what is not learnt."""
        names = set(self.not_learnt)
        return tuple(motion for motion, unknowns in MOTIONS.items() if names & unknowns)

    @property
    def not_learnt(self) -> tuple[str, ...]:
        """The unknowns that the drive hardly determined."""
        return not_learnt(self.sd)


def not_learnt(sd: Array) -> tuple[str, ...]:
    """Return the unknowns that a drive hardly determined, by their standard deviations (15,)."""
    unlearnt = sd[:ROBOT] > LEARNT * PRIORS[:ROBOT]
    return tuple(NAMES[index] for index in np.flatnonzero(unlearnt))


def calibrate(
    log: DriveLog,
    spec: RobotSpec,
    taped: Field,
    start: Pose2,
    start_covariance: Array,
    report: Report = lambda seconds, solution: None,
) -> Calibration:
    """Find the path of a drive, and how the robot differs from its description.

    Args:
        log: the drive.
        spec: the robot as described.
        taped: the field as drawn.
        start: pose of the robot at the first picture, as given.
        start_covariance: (3, 3) covariance of that pose [m, m, rad].
        report: called after each window with its length [s] and its solution.

    Raises:
        CalibrationError: the drive is too short, stands still or shows no tape, or its edges are
            not those of the field.
    """
    _check(log)
    drive = FieldDrive(log, spec, taped)
    path = begin(drive, start, start_covariance)
    _follow(path, BEGINNING_S, report)
    if _is_astray(path):
        path = _from_elsewhere(path, drive, start, start_covariance, report)
    _check_fit(path)
    return _with_unlearnt_left(path, path.compare_starts())


def _follow(path: DrivePath, known: float, report: Report) -> None:
    """Follow all of a drive; its beginning, up to a time after its first picture [s], is known."""
    for window in WINDOWS:
        if window > known and not path.whole:
            path.grow(window)
        if window >= BEGINNING_S:
            report(path.seconds, path.solution)


def _is_astray(path: DrivePath) -> bool:
    return path.lost_at is not None or not path.fits


def _from_elsewhere(
    path: DrivePath, drive: FieldDrive, given: Pose2, covariance: Array, report: Report
) -> DrivePath:
    """Return the path from another start, if the whole drive fits there; else the same.

    The beginning of a drive may look alike in places that what comes later tells apart.
    """
    wrong = path.start
    path.compare_starts()
    for start in (path.start, given):
        if alike(start, wrong):
            continue
        other = DrivePath(drive, start, covariance)
        try:
            _follow(other, 0.0, report)
        except CalibrationError:
            continue
        if not _is_astray(other):
            return other
    return path


def _check(log: DriveLog) -> None:
    if len(log.stamps) < 2 or log.stamps[-1] - log.stamps[0] < SHORTEST_S:
        raise CalibrationError(f"the drive is too short; valid is {SHORTEST_S:g} s or more")
    if not np.isfinite(log.pixels).any():
        raise CalibrationError("no picture of the drive shows tape of this width")
    if np.ptp(log.wheel_angles, axis=0).max() < 1.0:
        raise CalibrationError("the robot stood still; it has to drive")


def _check_fit(path: DrivePath) -> None:
    if not path.fits:
        raise CalibrationError(
            f"{100 * path.solution.share:.0f} % of the edges that were seen lie on the field's: "
            "the robot was moved by hand, or this is another field"
        )
    path.require_whole()


def _with_unlearnt_left(path: DrivePath, others: Sequence[Pose2]) -> Calibration:
    """Adjust once more; unknowns that the drive did not determine stay as described.

    Others are starts from which the drive fits as well.
    """
    solution = path.solution
    sd = np.sqrt(np.diag(solution.covariance))
    unlearnt = sd > UNTOLD * PRIORS
    unlearnt[ROBOT:] = False
    if unlearnt.any():
        solution = path.adjusted_again(Weights(sd=np.where(unlearnt, FIXED, 1.0) * PRIORS))
        sd[unlearnt] = PRIORS[unlearnt]
    values = np.where(unlearnt, 0.0, solution.state.values)
    sd[ROTATION] = np.hypot(sd[ROTATION], _turned_by_others(values[ROTATION], sd[ROTATION]))
    remarks = path.remarks
    if others:
        remarks += (
            f"the drive fits as well if it began at {' or '.join(map(start_text, others))}; only "
            f"the given start tells that it began at {start_text(path.start)}",
        )
    quality = quality_of(solution, PRIORS, not_learnt(sd))
    sd[~unlearnt] *= quality.interval_factor
    return Calibration(values, sd, solution, quality, remarks)


def _turned_by_others(rotation: Array, sd: Array) -> Array:
    """Return how uncertain each axis of a rotation is as the others are (3,) [rad].

    Rotations do not just add up: one about the vertical that is not known also turns the axes of
    the other two. This is the second term of Baker, Campbell and Hausdorff.
    """
    size = np.square(rotation) + np.square(sd)
    following, last = [1, 2, 0], [2, 0, 1]
    variance = size[following] * sd[last] ** 2 + size[last] * sd[following] ** 2
    result: Array = np.sqrt(variance) / 2
    return result
