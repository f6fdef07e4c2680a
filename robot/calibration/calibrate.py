"""Calibrates a robot by a drive on a known field.

First the path is not known, and the camera may be degrees askew: then every adjustment of the whole
drive ends in a wrong place. So the drive is adjusted in windows that grow. In each, the path is
followed a little farther with what is known by then, and all of it is adjusted again.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from robot.calibration.adjustment import (
    Adjustment,
    CalibrationError,
    Solution,
    State,
    Weights,
    residual_sd,
)
from robot.calibration.drive_log import DriveLog
from robot.calibration.sightings import Sightings
from robot.calibration.tracking import follow_path
from robot.calibration.unknowns import (
    COUNT,
    DELAY,
    LEFT,
    PRIORS,
    RIGHT,
    ROBOT,
    SEPARATION,
    UNKNOWNS,
    index_of,
)
from robot.calibration.wheel_motion import WheelMotion
from robot.description.spec import RobotSpec
from robot.fields.field import Field
from robot.geometry import Array, Pose2

WINDOWS = (2.0, 3.5, 6.0, 10.0, 16.0, 26.0, 42.0, 70.0, 120.0, 200.0, 350.0, 600.0)
"""Lengths of the drive's beginning that are adjusted one after the other [s]."""

SHORTEST_S = 5.0
"""Shortest drive that is adjusted [s]."""

LEAST_WAY, LEAST_TURN = 0.5, 1.5
"""Least way [m], and least turning each way round [rad]. A robot that only turns does not show in
which direction it would drive, and one that only drives straight does not show about which point it
turns: there the smallest systematic error would decide."""

LEARNT, UNTOLD = 0.5, 0.9
"""An unknown is learnt if its standard deviation is below the first share of the prior's. Above the
second, the drive tells nothing of it, and it is left as it was; in between it is part of what the
drive does tell."""

FIXED = 1e-3
"""Factor of a prior that leaves an unknown as it was."""

FAR_OFF = 3.0
"""The path is not the true one if the edges lie so many times farther off than was expected."""

LEAST_SEEN = 0.7
"""Share of the edges seen that must lie on the field's; else the path is not the true one."""


@dataclass(frozen=True)
class Calibration:
    """The result of a calibration."""

    values: Array
    """(15,) differences from the description, in the order of ``UNKNOWNS``; zero if not learnt."""
    sd: Array = field(repr=False)
    """(15,) their standard deviations; that of the prior if not learnt."""
    solution: Solution = field(repr=False)
    residual: float
    """Robust standard deviation of the edges' distances, in those that were expected."""

    @property
    def not_learnt(self) -> tuple[str, ...]:
        """The robot's unknowns of which the drive told little."""
        unlearnt = self.sd[:ROBOT] > LEARNT * PRIORS[:ROBOT]
        return tuple(UNKNOWNS[place].name for place in np.flatnonzero(unlearnt))


def calibrate(
    log: DriveLog,
    spec: RobotSpec,
    taped: Field,
    start: Pose2,
    start_covariance: Array,
    report: Callable[[float, Solution], None] = lambda seconds, solution: None,
) -> Calibration:
    """Find the path of a drive, and how the robot differs from its description.

    Args:
        log: the drive.
        spec: the robot as described.
        taped: the field as drawn.
        start: where the robot was at the first picture, as told.
        start_covariance: of that pose (3, 3) [m, m, rad].
        report: called after each window with its length [s] and its solution.

    Raises:
        CalibrationError: the drive is too short, stands still or shows no tape, or its edges are
            not those of the field.
    """
    _check(log, spec)
    seen = Sightings.of(log, spec, taped)
    given_pose = start.to_array()
    state = State(np.zeros(COUNT), given_pose[None].copy(), np.zeros((1, 2)))
    covariance, stamps = start_covariance, log.stamps - log.stamps[0]
    for number, window in enumerate(WINDOWS):
        count = int(np.searchsorted(stamps, window))
        part, motion = seen.part(0, count), WheelMotion.of(log.until(count), spec)
        state = follow_path(state, covariance, part, motion, first=number == 0)
        adjustment = Adjustment(part, motion, given_pose, start_covariance)
        for weights in _weights(window):
            solution = adjustment.solve(state, weights)
            state = solution.state
        covariance = solution.pose_covariance
        report(min(window, float(stamps[-1])), solution)
        if count == len(stamps):
            break
    _check_fit(log, solution)
    return _with_unlearnt_left(adjustment, solution, _weights(window)[-1])


def _check(log: DriveLog, spec: RobotSpec) -> None:
    if len(log.stamps) < 2 or log.stamps[-1] - log.stamps[0] < SHORTEST_S:
        raise CalibrationError(f"the drive is too short; valid is {SHORTEST_S:g} s or more")
    if not np.isfinite(log.pixels).any():
        raise CalibrationError("no picture of the drive shows tape of this width")
    if np.ptp(log.wheel_angles, axis=0).max() < 1.0:
        raise CalibrationError("the robot stood still; it has to drive and turn")
    left, right = (spec.joints[place].radius for place in spec.axle)
    rolled = np.diff(log.wheel_angles, axis=0) * (left, right)
    way, turns = np.abs(rolled.mean(axis=1)).sum(), (rolled[:, 1] - rolled[:, 0]) / spec.track
    to_left, to_right = turns[turns > 0].sum(), -turns[turns < 0].sum()
    if way < LEAST_WAY or min(to_left, to_right) < LEAST_TURN:
        raise CalibrationError(
            f"the robot drove {way:.1f} m, and turned {math.degrees(to_left):.0f} degrees to the "
            f"left and {math.degrees(to_right):.0f} to the right; valid is {LEAST_WAY:g} m or more "
            f"and {math.degrees(LEAST_TURN):.0f} degrees or more each way round"
        )


def _check_fit(log: DriveLog, solution: Solution) -> None:
    share = len(solution.misses.residuals) / max(1, int(np.isfinite(log.pixels[:, :, 0]).sum()))
    if share < LEAST_SEEN or residual_sd(solution.misses) > FAR_OFF:
        raise CalibrationError(
            f"{100 * share:.0f} % of the edges that were seen lie on the field's: the robot did "
            "not start where it was told, or this is another field"
        )


def _with_unlearnt_left(
    adjustment: Adjustment, solution: Solution, weights: Weights
) -> Calibration:
    """Adjust once more, with all that was not learnt left as it was."""
    sd = np.sqrt(np.diag(solution.covariance))
    unlearnt = sd > UNTOLD * PRIORS
    unlearnt[ROBOT:] = False
    if unlearnt.any():
        stiffness = np.where(unlearnt, FIXED, weights.stiffness)
        solution = adjustment.solve(solution.state, Weights(stiffness, weights.gate, weights.doubt))
        sd[unlearnt] = PRIORS[unlearnt]
    values = np.where(unlearnt, 0.0, solution.state.values)
    return Calibration(values, sd, solution, residual_sd(solution.misses))


def _weights(window: float) -> list[Weights]:
    """Return how much is believed in the adjustments of a window [s], one after the other.

    In short windows the wheels and the place of the camera are stiff: with all free, a drive of two
    seconds is explained best by a robot of twice the size, or by one that looks aside.
    """
    free = np.ones(COUNT)
    if window < 3:
        turned = 0.1 * free
        turned[index_of(["camera_roll", "camera_pitch"])] = 1.0
        return [
            Weights(0.01 * free, gate=0.25, doubt=100.0),
            Weights(turned, gate=0.15, doubt=30.0),
            Weights(turned, gate=0.08, doubt=8.0),
        ]
    if window < 6:
        slow = [LEFT, RIGHT, SEPARATION, DELAY, *index_of(["camera_x", "camera_y"])]
        free[slow] = 0.1
        return [Weights(free, gate=0.06, doubt=8.0), Weights(free, gate=0.03, doubt=2.0)]
    if window < 12:
        return [Weights(free, gate=0.06, doubt=4.0), Weights(free, gate=0.03)]
    return [Weights(free)]
