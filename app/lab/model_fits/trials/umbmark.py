"""UMBmark: wheel diameters and track from squares driven both ways round.

Borenstein and Feng, Measurement and correction of systematic odometry errors in mobile robots,
IEEE Transactions on Robotics and Automation 12(6), 1996; the symbols are the paper's.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from app.lab.model_fits.fit_error import FitError
from app.lab.model_fits.motion.run import MotionRun
from app.lab.model_fits.motion.twists import chained, motions_of, relative, twists_of
from robot.driving.differential_drive import WheelMultipliers
from robot.geometry import Array

SHORTEST = 0.1
"""Shorter straight runs [m] do not tell of the distance."""

LARGEST = 0.5
"""Errors of a corner or a side beyond this [rad] are no small errors."""


@dataclass(frozen=True)
class Umbmark:
    """What squares tell of a robot's wheels."""

    centre_cw: tuple[float, float]
    """Mean return error of the squares driven clockwise: x_cg and y_cg, cw [m]."""
    centre_ccw: tuple[float, float]
    """The same anticlockwise [m]."""
    spread_cw: float
    """Standard deviation of the return errors about their centre [m]: what is not systematic."""
    spread_ccw: float
    """The same anticlockwise [m]."""
    alpha: float
    """By how much a corner falls short of the quarter turn [rad]; from the track."""
    beta: float
    """By how much a side bends to the left [rad]; from unequal wheels."""
    wheel_ratio: float
    """E_d: right wheel's diameter by the left one's."""
    track_ratio: float
    """E_b: true track by that of the description, both by the mean diameter."""
    distance: float
    """True way by odometry's of straight runs: the mean diameter, which squares do not show."""

    @property
    def left_factor(self) -> float:
        """c_l, for the ways of the left wheel: both factors keep the mean diameter."""
        return 2 / (self.wheel_ratio + 1)

    @property
    def right_factor(self) -> float:
        """c_r, for the ways of the right wheel."""
        return 2 / (1 / self.wheel_ratio + 1)

    @property
    def worst(self) -> float:
        """E_max,syst [m]: the farther of the two centres from no error."""
        return max(math.hypot(*self.centre_cw), math.hypot(*self.centre_ccw))

    def wheel_multipliers(self) -> WheelMultipliers:
        """Factors on the description's radii and track."""
        mean = self.distance
        return WheelMultipliers(
            mean * self.left_factor, mean * self.right_factor, mean * self.track_ratio
        )


def umbmark(
    errors_cw: Array, errors_ccw: Array, side: float, track: float, distance: float = 1.0
) -> Umbmark:
    """Wheel and track errors from the ends of squares.

    With the centres of gravity, in metres, of a robot that starts along x:

        alpha = (x_cw + x_ccw) / (-4 L) = (y_cw - y_ccw) / (-4 L)
        beta = (x_cw - x_ccw) / (-4 L) = (y_cw + y_ccw) / (-4 L)
        R = (L / 2) / sin(beta / 2),  E_d = (R + b / 2) / (R - b / 2),  E_b = 90° / (90° - alpha)

    The paper takes one of the two forms; here they are averaged. As they hold for small angles
    only, they are then made exact: the angles are corrected until the squares that they make end
    where those that were driven did. So are L and b: sides are as long as the robot truly goes,
    and wheels as far apart as they truly are.

    Args:
        errors_cw: (n, 2) [m] true end minus end by odometry of squares to the right.
        errors_ccw: (m, 2) the same to the left.
        side: L, a side of the square [m].
        track: b, distance between the wheels as described [m].
        distance: true way by odometry's of straight runs; see ``distance_factor``.

    Raises:
        FitError: no squares in one direction, or errors too large for a square of that size.
    """
    for name, errors in (("clockwise", errors_cw), ("anticlockwise", errors_ccw)):
        if errors.ndim != 2 or errors.shape[1] != 2 or len(errors) == 0:
            raise FitError(f"errors of squares {name} of shape {errors.shape}; valid are (n, 2)")
    cw, ccw = errors_cw.mean(axis=0), errors_ccw.mean(axis=0)
    alpha, beta = _exact_angles(cw, ccw, distance * side, distance * track)
    track_ratio = _track_ratio(alpha)
    bend = _bend(alpha, beta, distance * side, distance * track)
    return Umbmark(
        (float(cw[0]), float(cw[1])),
        (float(ccw[0]), float(ccw[1])),
        _spread(errors_cw),
        _spread(errors_ccw),
        alpha,
        beta,
        (1 + bend) / (1 - bend),
        track_ratio,
        distance,
    )


def return_errors(runs: Sequence[MotionRun]) -> Array:
    """(n, 2) [m]: true end minus end by odometry of each run, in the axes of its start."""
    ends = [
        (relative(run.truth[0], run.truth[-1]) - relative(run.odometry[0], run.odometry[-1]))[:2]
        for run in runs
    ]
    return np.array(ends).reshape(-1, 2)


def distance_factor(runs: Sequence[MotionRun]) -> float:
    """True way by odometry's of straight runs, forward or back; each may bend to an arc.

    Raises:
        FitError: there is no run, or one that went nowhere.
    """
    ways = [(_way(run.truth), _way(run.odometry)) for run in runs]
    if not ways or min(abs(told) for _, told in ways) < SHORTEST:
        raise FitError(f"straight runs of {SHORTEST:g} m or more are needed to tell the distance")
    return sum(true / told for true, told in ways) / len(ways)


def _way(poses: Array) -> float:
    return float(twists_of(relative(poses[0], poses[-1]))[0])


def _exact_angles(cw: Array, ccw: Array, side: float, track: float) -> tuple[float, float]:
    alpha, beta = 0.0, 0.0
    for _ in range(8):
        d_alpha, d_beta = _small_angles(
            cw - _square(-1, alpha, beta, side, track),
            ccw - _square(1, alpha, beta, side, track),
            side,
        )
        alpha, beta = alpha + d_alpha, beta + d_beta
        if max(abs(alpha), abs(beta)) > LARGEST:
            raise FitError(
                f"squares of {side:g} m end {np.hypot(*cw):.3f} and {np.hypot(*ccw):.3f} m off "
                "on the mean; UMBmark is for errors that are small against the side"
            )
    return alpha, beta


def _small_angles(cw: Array, ccw: Array, side: float) -> tuple[float, float]:
    alpha = (cw[0] + ccw[0] + cw[1] - ccw[1]) / (-8 * side)
    beta = (cw[0] - ccw[0] + cw[1] + ccw[1]) / (-8 * side)
    return float(alpha), float(beta)


def _square(way: int, alpha: float, beta: float, side: float, track: float) -> Array:
    """Where a square ends whose sides bend and whose corners fall short; way 1 is to the left.

    In its corners a robot on unequal wheels goes a little ahead or back: it turns about another
    point than the middle between them.
    """
    ahead = way * math.pi / 4 * track * _bend(alpha, beta, side, track)
    legs = np.array([[side, 0.0, beta], [ahead, 0.0, way * (math.pi / 2 - alpha)]])
    end: Array = chained(np.tile(motions_of(legs), (4, 1)))[-1, :2]
    return end


def _track_ratio(alpha: float) -> float:
    return (math.pi / 2) / (math.pi / 2 - alpha)


def _bend(alpha: float, beta: float, side: float, track: float) -> float:
    """(b / 2) / R for sides that bend by beta; R is infinite for equal wheels, this is not."""
    return math.sin(beta / 2) / (side / 2) * _track_ratio(alpha) * track / 2


def _spread(errors: Array) -> float:
    """Standard deviation along both axes together [m]; 0 of a single square."""
    if len(errors) < 2:
        return 0.0
    return float(np.sqrt(errors.var(axis=0, ddof=1).sum()))
