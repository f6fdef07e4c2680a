"""How a lens bends light: the models that ROS's ``camera_info`` names.

A model maps ideal image coordinates (x, y) = (X/Z, Y/Z) to bent ones, in focal lengths from the
principal point. It is used only as far out as it is one-to-one.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property
from typing import Protocol

import cv2
import numpy as np
from numpy.polynomial import Polynomial

from robot.geometry import Array
from robot.undistortion import straightened, undistorted

COEFFICIENTS = {
    "plumb_bob": ("k1", "k2", "p1", "p2", "k3"),
    "rational_polynomial": ("k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"),
    "equidistant": ("k1", "k2", "k3", "k4"),
}
"""The coefficients of each model, by its name in ``camera_info``."""

FOUND = 2e-5
"""The ideal coordinates of a point must bend back this close to the point [focal lengths]."""


class Distortion(Protocol):
    """One lens's way of bending light."""

    @property
    def widest(self) -> float:
        """Least radius of ideal coordinates, the tangent of an angle, that is not one-to-one."""
        ...

    def bend(self, ideal: Array) -> Array:
        """Return the bent coordinates (n, 2) of ideal ones (n, 2)."""
        ...

    def straighten(self, bent: Array) -> Array:
        """Return the ideal coordinates (n, 2) of bent ones (n, 2); nan where there are none."""
        ...


def distortion_of(model: str, coefficients: Array) -> Distortion:
    """Return the distortion of a model and its coefficients.

    Args:
        model: plumb_bob, rational_polynomial or equidistant.
        coefficients: (5,) k1, k2, p1, p2, k3; (8,) the same and k4, k5, k6; or (4,) k1 to k4.
    """
    if model == "equidistant":
        return Equidistant(coefficients)
    return Brown(np.concatenate([coefficients, np.zeros(8 - len(coefficients))]))


@dataclass(frozen=True, eq=False)
class Brown:
    """Radial and tangential distortion (Brown 1966), as OpenCV's first eight coefficients.

    With k4 = k5 = k6 = 0 it is ROS's plumb_bob, else rational_polynomial.
    """

    coefficients: Array = field(repr=False)
    """(8,) k1, k2, p1, p2, k3, k4, k5, k6."""

    def bend(self, ideal: Array) -> Array:
        """Return the bent coordinates (n, 2), by Brown's formula."""
        k1, k2, p1, p2, k3, k4, k5, k6 = self.coefficients
        x, y = ideal.T
        xy, r2 = x * y, x * x + y * y
        radial = (1 + r2 * (k1 + r2 * (k2 + r2 * k3))) / (1 + r2 * (k4 + r2 * (k5 + r2 * k6)))
        bent_x = x * radial + 2 * p1 * xy + p2 * (r2 + 2 * x * x)
        bent_y = y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * xy
        return np.column_stack([bent_x, bent_y])

    def straighten(self, bent: Array) -> Array:
        """Return the ideal coordinates (n, 2), by Newton's method, else by a slower search."""
        ideal = undistorted(np.ascontiguousarray(bent), self.coefficients, self.widest)
        lost = np.flatnonzero(np.isnan(ideal[:, 0]) & np.isfinite(bent).all(axis=1))
        if len(lost):
            ideal[lost] = self._searched(bent[lost])
        return np.asarray(ideal, np.float64)

    def _searched(self, bent: Array) -> Array:
        criteria = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 1000, 1e-12)
        given = bent.reshape(-1, 1, 2).astype(np.float64)
        ideal: Array = cv2.undistortPoints(
            given, np.eye(3), self.coefficients, criteria=criteria
        ).reshape(-1, 2).astype(np.float64)  # fmt: skip
        # The search returns a point even if there is no solution.
        with np.errstate(invalid="ignore", over="ignore"):
            offset = np.abs(self.bend(ideal) - bent).max(axis=1)
            outside = (ideal**2).sum(axis=1) >= self.widest**2
        ideal[~(offset < FOUND) | outside] = np.nan
        return ideal

    @cached_property
    def widest(self) -> float:
        """Radius r at which the bent radius, of the radial terms alone, grows no more."""
        k1, k2, _, _, k3, k4, k5, k6 = self.coefficients
        # The slope is solved for 1 / r^2, so that a coefficient near zero does no harm.
        above, below = Polynomial([1, k1, k2, k3]), Polynomial([1, k4, k5, k6])
        q = Polynomial([0, 1])
        slope = (above + 2 * q * above.deriv()) * below - 2 * q * above * below.deriv()
        rising = np.asarray(slope.coef, np.float64), np.asarray(below.coef, np.float64)
        return math.sqrt(min(_least_root(part) for part in rising))


@dataclass(frozen=True, eq=False)
class Equidistant:
    """A fisheye lens (Kannala and Brandt 2006; OpenCV's ``fisheye``).

    The bent radius is t (1 + k1 t^2 + k2 t^4 + k3 t^6 + k4 t^8) of the angle t to the view.
    Directions of 90 degrees and more have no ideal coordinates: they are left out.
    """

    coefficients: Array = field(repr=False)
    """(4,) k1 to k4."""

    def bend(self, ideal: Array) -> Array:
        """Return the bent coordinates (n, 2)."""
        radius = np.hypot(ideal[:, 0], ideal[:, 1])
        angle = np.arctan(radius)
        k1, k2, k3, k4 = self.coefficients
        square = angle * angle
        bent = angle * (1 + square * (k1 + square * (k2 + square * (k3 + square * k4))))
        with np.errstate(divide="ignore", invalid="ignore"):
            scale = np.where(radius > 0, bent / radius, 1.0)
        result: Array = ideal * scale[:, None]
        return result

    def straighten(self, bent: Array) -> Array:
        """Return the ideal coordinates (n, 2)."""
        ideal = straightened(np.ascontiguousarray(bent), self.coefficients, self._widest_angle)
        return np.asarray(ideal, np.float64)

    @property
    def widest(self) -> float:
        """Tangent of the widest angle."""
        angle = self._widest_angle
        return math.tan(angle) if angle < math.pi / 2 else math.inf

    @cached_property
    def _widest_angle(self) -> float:
        k1, k2, k3, k4 = self.coefficients
        square = _least_root(np.array([1, 3 * k1, 5 * k2, 7 * k3, 9 * k4]))
        return min(math.sqrt(square), math.pi / 2)


def _least_root(rising: Array) -> float:
    """Return the least positive root of a polynomial that begins with 1; inf without one."""
    roots = np.roots(rising)
    real = roots[np.isreal(roots) & (roots.real > 0)].real
    return float(1 / real.max()) if len(real) else math.inf
