"""UMBmark: wheel diameters and track from squares driven in both directions.

Borenstein and Feng, Measurement and correction of systematic odometry errors in mobile robots,
IEEE Transactions on Robotics and Automation 12(6), 1996; the symbols are the paper's.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from app.features.lab.model_fits.likelihood import FitError
from app.features.lab.model_fits.motions import MotionRun, chained, motions_of, relative, twists_of
from robot.driving.differential_drive import WheelMultipliers
from robot.geometry import Array

LARGEST = 2.0
"""Largest return error, in sides of the square: UMBmark is for small errors."""


@dataclass(frozen=True)
class Umbmark:
    """Wheel and track errors of a robot, from squares."""

    centre_cw: tuple[float, float]
    """Mean return error of the squares driven clockwise: x_cg and y_cg, cw [m]."""
    centre_ccw: tuple[float, float]
    """The same anticlockwise [m]."""
    spread_cw: float
    """Standard deviation of the return errors about their centre [m]: the random part."""
    spread_ccw: float
    """The same anticlockwise [m]."""
    alpha: float
    """Angle by which a corner falls short of the quarter turn [rad]; caused by the track."""
    beta: float
    """Angle by which a side bends to the left [rad]; caused by unequal wheels."""
    wheel_ratio: float
    """E_d: diameter of the right wheel divided by that of the left wheel."""
    track_ratio: float
    """E_b: true track divided by the described track, both relative to the mean diameter."""
    distance: float
    """True distance divided by odometry's, on straight runs: the error of the mean diameter, which
    squares do not show."""

    @property
    def worst(self) -> float:
        """E_max,syst [m]: the larger distance of the two centres from zero error."""
        return max(math.hypot(*self.centre_cw), math.hypot(*self.centre_ccw))

    def wheel_multipliers(self) -> WheelMultipliers:
        """Factors on the description's radii and track."""
        mean = self.distance
        left, right = 2 / (self.wheel_ratio + 1), 2 / (1 / self.wheel_ratio + 1)
        return WheelMultipliers(mean * left, mean * right, mean * self.track_ratio)


def umbmark(
    errors_cw: Array, errors_ccw: Array, side: float, track: float, distance: float = 1.0
) -> Umbmark:
    """Compute wheel and track errors from the ends of squares.

    The paper computes them from sums of small angles. Here alpha and beta are the angles whose
    squares end nearest to the centres of gravity. With the true lengths L and b

        R = (L / 2) / sin(beta / 2),  E_d = (R + b / 2) / (R - b / 2),  E_b = 90° / (90° - alpha)

    Errors (n, 2) [m] are true ends minus ends by odometry, of squares to the right and to the left.
    Side [m] and track [m] are as described; the distance is the ``distance_factor``.

    Raises:
        FitError: the errors are too large for a square of that size.
    """
    cw, ccw = errors_cw.mean(axis=0), errors_ccw.mean(axis=0)
    lengths = distance * side, distance * track

    def misses(angles: Array) -> Array:
        return np.concatenate(
            [cw - _square(-1, angles, *lengths), ccw - _square(1, angles, *lengths)]
        )

    alpha, beta = least_squares(misses, np.zeros(2), xtol=1e-14, ftol=1e-14, gtol=1e-14).x.tolist()
    if max(np.hypot(*cw), np.hypot(*ccw)) > LARGEST * side:
        raise FitError(
            f"squares of {side:g} m end {np.hypot(*cw):.3f} and {np.hypot(*ccw):.3f} m off "
            "on the mean; UMBmark is for errors that are small against the side"
        )
    bend = _bend(alpha, beta, *lengths)
    return Umbmark(
        (float(cw[0]), float(cw[1])),
        (float(ccw[0]), float(ccw[1])),
        _spread(errors_cw),
        _spread(errors_ccw),
        alpha,
        beta,
        (1 + bend) / (1 - bend),
        _track_ratio(alpha),
        distance,
    )


def return_errors(runs: Sequence[MotionRun]) -> Array:
    """Return (n, 2) [m]: true end minus end by odometry of each run, in the axes of its start."""
    ends = [
        (relative(run.truth[0], run.truth[-1]) - relative(run.odometry[0], run.odometry[-1]))[:2]
        for run in runs
    ]
    return np.array(ends).reshape(-1, 2)


def distance_factor(runs: Sequence[MotionRun]) -> float:
    """Return true distance by odometry's of straight runs, forward or back; runs may be arcs."""
    ways = [(_way(run.truth), _way(run.odometry)) for run in runs]
    return sum(true / by_odometry for true, by_odometry in ways) / len(ways)


def _way(poses: Array) -> float:
    return float(twists_of(relative(poses[0], poses[-1]))[0])


def _square(way: int, angles: Array, side: float, track: float) -> Array:
    """Return the end of a square whose sides bend and whose corners fall short; way 1 is left.

    In corners a robot with unequal wheels moves a little forward or back: it turns about a point
    beside the middle between the wheels.
    """
    alpha, beta = angles.tolist()
    ahead = way * math.pi / 4 * track * _bend(alpha, beta, side, track)
    legs = np.array([[side, 0.0, beta], [ahead, 0.0, way * (math.pi / 2 - alpha)]])
    end: Array = chained(np.tile(motions_of(legs), (4, 1)))[-1, :2]
    return end


def _track_ratio(alpha: float) -> float:
    return (math.pi / 2) / (math.pi / 2 - alpha)


def _bend(alpha: float, beta: float, side: float, track: float) -> float:
    """Return (b / 2) / R for sides that bend by beta; finite even if R is infinite."""
    return math.sin(beta / 2) / (side / 2) * _track_ratio(alpha) * track / 2


def _spread(errors: Array) -> float:
    """Return the standard deviation along both axes together [m]; 0 for a single square."""
    if len(errors) < 2:
        return 0.0
    return float(np.sqrt(errors.var(axis=0, ddof=1).sum()))
