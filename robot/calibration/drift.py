"""Checks a calibrated robot by a few seconds of driving: has it drifted, or its camera moved?

Only the camera's three angles are free; all else is as calibrated. The square of their shift by its
covariance says whether the camera has moved (chi-square, three degrees of freedom).
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from robot.calibration.adjustment import (
    Adjustment,
    CalibrationError,
    DriveEstimate,
    Solution,
    Weights,
    residual_sd,
)
from robot.calibration.drive_log import DriveLog
from robot.calibration.sightings import Sightings
from robot.calibration.tracking import follow_path
from robot.calibration.wheel_motion import WheelMotion
from robot.description.spec import RobotSpec
from robot.description.unknowns import COUNT, PRIORS, ROTATION, SHIFT
from robot.fields.field import Field
from robot.geometry import Array
from robot.localization.models.entry_field import EntryField

START_COVARIANCE = np.diag(np.square([0.02, 0.02, 0.05]))
"""How well the first pose of a window is known [m, m, rad]: it was estimated with the calibration
that is checked."""
LEAST_SHARE, MOST_OFF = 0.8, 1.5
"""A path fits if at least this share of the seen edges lies on the field's edges, and if their
distances are at most this multiple of the expected ones."""
MOVED = 25.0
"""If the square of a shift by its covariance is larger, the camera has moved: one of 60,000 windows
exceeds it by chance."""
SHIFTED, SHIFTED_MOST = 0.0002, 0.0015
"""Standard deviation of how far a camera is shifted that was turned [m]: while the question is
whether it was turned, and when that is known. A camera that may be anywhere may look anywhere."""
STAGES = ((0.06, 4.0), (0.03, 1.0))
"""Gates [m] and doubts, one after the other, where the camera has moved."""


@dataclass(frozen=True, eq=False)
class Known:
    """A robot's unknowns, as far as they are known."""

    values: Array
    """(15,) differences from the description, in the order of ``UNKNOWNS``."""
    covariance: Array = field(repr=False)
    """(15, 15) their covariance."""

    def loosened(self, shifted: float) -> Known:
        """Return the same for a robot whose camera may be turned, and shifted by a distance [m]."""
        added = np.zeros(COUNT)
        added[ROTATION], added[SHIFT] = PRIORS[ROTATION], shifted
        return replace(self, covariance=self.covariance + np.diag(added**2))


@dataclass(frozen=True, eq=False)
class DriftFinding:
    """The result of a window."""

    poses: Array = field(repr=False)
    """(k, 3) poses at the window's pictures."""
    loose: Known = field(repr=False)
    """The robot's unknowns by this window, if its camera may have been bumped."""
    prior: Known = field(repr=False)
    """What was known before."""
    loosened: Known = field(repr=False)
    """What was known before, if the camera may have been bumped."""
    pose_covariance: Array = field(repr=False)
    """(3, 3) covariance of the last pose."""
    share: float
    """Share of the seen edges that lie near the field's edges."""
    residual: float
    """Robust standard deviation of the edges' distances, as a multiple of the expected one."""

    @property
    def fits(self) -> bool:
        """Whether the seen edges lie on the field's edges."""
        return self.share >= LEAST_SHARE and self.residual <= MOST_OFF

    @property
    def shift(self) -> Array:
        """(3,) how far the camera seems to be turned from its calibration [rad]."""
        return self.loose.values[ROTATION] - self.prior.values[ROTATION]

    @property
    def significance(self) -> float:
        """Square of the shift by its covariance."""
        covariance = self.loose.covariance[ROTATION, ROTATION]
        return float(self.shift @ np.linalg.solve(covariance, self.shift))

    @property
    def tight(self) -> Known:
        """The robot's unknowns by this window, if its camera was not bumped."""
        loosened = np.linalg.inv(self.loosened.covariance)
        seen = np.linalg.inv(self.loose.covariance) - loosened
        pull = seen @ self.loose.values + loosened @ (self.loose.values - self.prior.values)
        before = np.linalg.inv(self.prior.covariance)
        covariance = np.asarray(np.linalg.inv(seen + before), np.float64)
        return Known(covariance @ (pull + before @ self.prior.values), covariance)


class DriftCheck:
    """Checks a robot's calibration on one field."""

    def __init__(self, spec: RobotSpec, taped: Field, entries: EntryField) -> None:
        """Check a robot.

        Args:
            spec: the description from which the differences count.
            taped: the field.
            entries: the field's ``entry_table``.
        """
        self._spec, self._field, self._entries = spec, taped, entries

    def check(self, log: DriveLog, poses: Array, known: Known) -> DriftFinding | None:
        """Return the result of a window, by one step from poses (k, 3) of pictures; None if none.

        This is cheap, and enough while the robot is as calibrated.
        """
        adjustment, _, _ = self._adjustment(log, poses[0])
        state = DriveEstimate(known.values, poses, np.zeros((len(poses), 2)))
        loose = known.loosened(SHIFTED)
        try:
            solution = adjustment.solve(state, _weights(loose, STAGES[-1]), most=1)
        except CalibrationError:
            return None
        return _finding(solution, known, loose)

    def measure(
        self, log: DriveLog, start: Array, known: Known, shifted: float = SHIFTED
    ) -> DriftFinding | None:
        """Return the result of a window, by following its path from the first pose; None if none.

        Args:
            log: the window.
            start: (3,) pose of its first picture.
            known: what was known before; the camera may have been bumped since.
            shifted: how far the camera may have been shifted by that [m].
        """
        adjustment, seen, motion = self._adjustment(log, start)
        state = DriveEstimate(known.values, start[None], np.zeros((1, 2)))
        state = follow_path(state, START_COVARIANCE, seen, motion, self._entries, first=True)
        loose = known.loosened(shifted)
        try:
            for stage in STAGES:
                solution = adjustment.solve(state, _weights(loose, stage))
                state = solution.state
        except CalibrationError:
            return None
        return _finding(solution, known, loose)

    def _adjustment(self, log: DriveLog, start: Array) -> tuple[Adjustment, Sightings, WheelMotion]:
        seen = Sightings.of(log, self._spec, self._field)
        motion = WheelMotion.of(log, self._spec)
        return Adjustment(seen, motion, start, START_COVARIANCE), seen, motion


def _weights(loose: Known, stage: tuple[float, float]) -> Weights:
    gate, doubt = stage
    return Weights(loose.values, gate=gate, doubt=doubt, covariance=loose.covariance)


def _finding(solution: Solution, known: Known, loosened: Known) -> DriftFinding:
    loose = Known(solution.state.values, solution.covariance)
    residual = residual_sd(solution.misses)
    poses = solution.state.poses
    return DriftFinding(
        poses, loose, known, loosened, solution.pose_covariance, solution.share, residual
    )
