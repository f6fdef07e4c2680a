"""ClosedCurve: a curve that ends where it begins, as the legs of one lap."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from scipy.interpolate import CubicSpline

from robot.errors import BrickPoseError
from robot.geometry import Array, Pose2, wrap_angle
from robot.navigation.legs import STEP, WayLeg, straight, turn
from robot.navigation.timed_way import Limits

Shape = Literal["figure_eight", "circle", "square", "points"]
SHAPES: tuple[Shape, ...] = get_args(Shape)
FEWEST_POINTS, NEAREST_POINTS = 3, 0.005
"""A curve by points has so many, and each is so far from the one before [m]."""
FINE = 0.001
"""Distance of the points by which a curve by points is measured [m]."""
MOST_OF_LAP = 1 / 8
"""The curvature of a figure-eight changes over at most this share of its lap."""


class CurveError(BrickPoseError, ValueError):
    """A curve that cannot be driven; the message says why, and what would be valid."""


@dataclass(frozen=True)
class ClosedCurve:
    """A curve, as it is asked for."""

    shape: Shape
    size: float = 0.19
    """Radius of the circles, or half of the square's side [m]; points have none."""
    points: tuple[tuple[float, float], ...] = ()
    """Of the shape ``points`` [m]: a smooth curve leads through them in the map, and back."""
    start: Pose2 | None = None
    """Where a shape begins, on its rim, and in which direction; None is where the robot stands."""

    def __post_init__(self) -> None:
        if (self.shape == "points") != bool(self.points):
            raise CurveError("points are given with the shape points, and with no other one")
        if not self.points:
            return
        if len(self.points) < FEWEST_POINTS:
            raise CurveError(f"{len(self.points)} points; valid are {FEWEST_POINTS} or more")
        around = np.array([*self.points, self.points[0]])
        apart = np.hypot(*np.diff(around, axis=0).T).min()
        if apart < NEAREST_POINTS:
            raise CurveError(
                f"two points in a row are {1000 * apart:.1f} mm apart; valid is "
                f"{1000 * NEAREST_POINTS:.0f} mm or more, also of the last from the first"
            )


@dataclass(frozen=True, eq=False)
class Lap:
    """One lap of a curve: legs from a place back to it. A single leg is driven without a stop."""

    legs: tuple[WayLeg, ...]

    @property
    def begin(self) -> Pose2:
        """Where it begins."""
        return Pose2.from_array(self.legs[0].poses[0])

    @property
    def poses(self) -> Array:
        """(n, 3) all of them [m, m, rad]."""
        return np.concatenate([leg.poses for leg in self.legs])

    def begun_near(self, pose: Pose2) -> Lap:
        """Return the same lap, begun at its point nearest to a pose, or at the leg with it."""
        if len(self.legs) > 1:
            away = [self._away(leg.poses, pose).min() for leg in self.legs]
            first = int(np.argmin(away))
            return Lap((*self.legs[first:], *self.legs[:first]))
        poses = self.legs[0].poses
        first = int(np.argmin(self._away(poses[:-1], pose)))
        around = np.array([0.0, 0.0, poses[-1, 2] - poses[0, 2]])
        later = poses[1 : first + 1] + around
        return Lap((WayLeg(np.concatenate([poses[first:], later])),))

    @staticmethod
    def _away(poses: Array, pose: Pose2) -> Array:
        """Return how far poses are [m]; a radian counts as a decimetre, as curves cross."""
        turned = 0.1 * np.abs(wrap_angle(poses[:, 2] - pose.theta))
        away: Array = np.hypot(poses[:, 0] - pose.x, poses[:, 1] - pose.y) + turned
        return away


def lap_of(wanted: ClosedCurve, start: Pose2, limits: Limits) -> Lap:
    """Return one lap of a curve.

    Args:
        wanted: which one.
        start: where shapes begin; a curve by points does not use it.
        limits: its curvature changes so slowly that the turning speed can follow.
    """
    if wanted.shape == "square":
        return _square(start, 2 * wanted.size)
    if wanted.shape == "points":
        return Lap((WayLeg(_through(np.array(wanted.points))),))
    length = 2 * math.pi * wanted.size * (2 if wanted.shape == "figure_eight" else 1)
    steps = 2 * math.ceil(length / STEP / 2)
    bend, turned = np.full(steps, 1 / wanted.size), 0.0
    if wanted.shape == "figure_eight":
        bend[steps // 2 :] *= -1
        eased = _eased(bend, length, wanted.size, limits)
        # It turns to the left already before it is there, or the circles would lie turned.
        turned = float((bend - eased)[: steps // 4].sum()) * length / steps
        bend = eased
    local = _integrated(bend, length, turned)
    moved = np.column_stack([start.apply(local[:, :2]), local[:, 2] + start.theta])
    return Lap((WayLeg(moved),))


def _square(start: Pose2, side: float) -> Lap:
    legs, pose = [], start
    for _ in range(4):
        along = straight(pose, side)
        corner = turn(along.end, along.end.theta + math.pi / 2)
        legs += [along, corner]
        pose = corner.end
    return Lap(tuple(legs))


def _eased(bend: Array, length: float, radius: float, limits: Limits) -> Array:
    """Return a figure-eight's curvature (n,), changed so slowly that the wheels can follow it."""
    speed = min(limits.speed, limits.turning * radius)
    over = min(2 * speed**2 / radius / limits.turning_gain, MOST_OF_LAP * length)
    half = math.ceil(over / (length / len(bend)) / 2)
    kernel = np.ones(2 * half + 1) / (2 * half + 1)
    eased: Array = np.convolve(np.pad(bend, half, mode="wrap"), kernel, "valid")
    return eased


def _integrated(bend: Array, length: float, heading: float) -> Array:
    """Return poses (n + 1, 3) along n equal steps of a length [m] with curvatures (n,) [1/m].

    They begin at (0, 0) with a heading [rad], and end there: what easing the curvature leaves open,
    some hundredths of a millimetre, is spread over the lap.
    """
    step = length / len(bend)
    # Curvatures belong to the middles of steps, and a step is the chord of an arc.
    theta = heading + np.concatenate([[0.0], np.cumsum(bend * step)])
    middle = (theta[:-1] + theta[1:]) / 2
    half = bend * step / 2
    chord = step * np.sinc(half / math.pi)
    x = np.concatenate([[0.0], np.cumsum(chord * np.cos(middle))])
    y = np.concatenate([[0.0], np.cumsum(chord * np.sin(middle))])
    share = np.linspace(0.0, 1.0, len(x))
    return np.column_stack([x - share * x[-1], y - share * y[-1], theta])


def _through(points: Array) -> Array:
    """Return poses (n, 3) along the smooth closed curve through points (m, 2) [m]."""
    around = np.concatenate([points, points[:1]])
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(around, axis=0).T))])
    spline = CubicSpline(along, around, bc_type="periodic")
    fine = spline(np.linspace(0.0, along[-1], math.ceil(along[-1] / FINE) + 1))
    travelled = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(fine, axis=0).T))])
    steps = max(16, math.ceil(travelled[-1] / STEP))
    parameter = np.interp(
        np.linspace(0.0, travelled[-1], steps + 1),
        travelled,
        np.linspace(0.0, along[-1], len(fine)),
    )
    ahead = spline(parameter, 1)
    return np.column_stack([spline(parameter), np.unwrap(np.arctan2(ahead[:, 1], ahead[:, 0]))])
