"""Inverse of the lens distortion: from distorted to ideal image coordinates.

Newton's method inverts Brown's formula. It takes two or three steps for each point, because it
starts from the solution of the neighbour: neighbours in a picture are neighbours without distortion
too. The fisheye's formula has one unknown, the angle, which is kept between bounds.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from robot.compiling import compiled

FOUND = 1e-13
"""A solution, distorted again, must be this close to the given point [focal lengths]."""
STEPS = 20
"""Largest number of steps: Newton's method takes 2 to 6, or does not converge."""
NEAR = 0.05
"""A point closer than this to the previous one starts from its solution [focal lengths]."""


@compiled()
def undistorted(
    bent: NDArray[np.float64], distortion: NDArray[np.float64], widest: float
) -> NDArray[np.float64]:
    """Return the ideal image coordinates (n, 2) of distorted ones (n, 2); nan without a solution.

    Args:
        bent: distorted coordinates [focal lengths] from the principal point; fastest row by row.
        distortion: (8,) k1, k2, p1, p2, k3, k4, k5, k6 of Brown's formula.
        widest: radius within which the formula is one-to-one; solutions beyond it are rejected.
    """
    k1, k2, p1, p2, k3, k4, k5, k6 = distortion
    ideal = np.empty_like(bent)
    x = y = before_u = before_v = np.nan
    for i in range(len(bent)):
        u, v = bent[i]
        if abs(u - before_u) < NEAR and abs(v - before_v) < NEAR:
            x, y = x + (u - before_u), y + (v - before_v)
        else:
            x, y = u, v
        result = False
        for _ in range(STEPS):
            xx, yy, xy = x * x, y * y, x * y
            r2 = xx + yy
            above = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3))
            below = 1.0 + r2 * (k4 + r2 * (k5 + r2 * k6))
            radial = above / below
            off_u = x * radial + 2.0 * p1 * xy + p2 * (r2 + 2.0 * xx) - u
            off_v = y * radial + p1 * (r2 + 2.0 * yy) + 2.0 * p2 * xy - v
            if abs(off_u) < FOUND and abs(off_v) < FOUND:
                result = r2 < widest * widest
                break
            # Partial derivatives of the formula; the Jacobian is symmetric.
            grows = 2.0 * (k1 + r2 * (2.0 * k2 + r2 * 3.0 * k3))
            grows -= 2.0 * (k4 + r2 * (2.0 * k5 + r2 * 3.0 * k6)) * radial
            grows /= below
            u_x = radial + xx * grows + 2.0 * p1 * y + 6.0 * p2 * x
            u_y = xy * grows + 2.0 * p1 * x + 2.0 * p2 * y
            v_y = radial + yy * grows + 6.0 * p1 * y + 2.0 * p2 * x
            determinant = u_x * v_y - u_y * u_y
            if not determinant > 0.0:
                break
            x -= (v_y * off_u - u_y * off_v) / determinant
            y -= (u_x * off_v - u_y * off_u) / determinant
        if result:
            ideal[i, 0], ideal[i, 1] = x, y
            before_u, before_v = u, v
        else:
            ideal[i] = np.nan
            before_u = before_v = np.nan
    return ideal


@compiled()
def straightened(
    bent: NDArray[np.float64], distortion: NDArray[np.float64], widest: float
) -> NDArray[np.float64]:
    """Return the ideal image coordinates (n, 2) of a fisheye's; nan without a solution.

    Args:
        bent: distorted coordinates [focal lengths] from the principal point.
        distortion: (4,) k1 to k4 of the polynomial of the angle to the view.
        widest: angle [rad] up to which the polynomial grows; solutions from there on are rejected.
    """
    k1, k2, k3, k4 = distortion
    ideal = np.empty_like(bent)
    square = widest * widest
    farthest = widest * (1.0 + square * (k1 + square * (k2 + square * (k3 + square * k4))))
    for i in range(len(bent)):
        radius = math.hypot(bent[i, 0], bent[i, 1])
        if not radius < farthest:
            ideal[i] = np.nan
            continue
        low, high, angle = 0.0, widest, min(radius, 0.5 * widest)
        for _ in range(60):
            t2 = angle * angle
            excess = angle * (1.0 + t2 * (k1 + t2 * (k2 + t2 * (k3 + t2 * k4)))) - radius
            if abs(excess) < FOUND:
                break
            if excess > 0.0:
                high = angle
            else:
                low = angle
            slope = 1.0 + t2 * (3.0 * k1 + t2 * (5.0 * k2 + t2 * (7.0 * k3 + t2 * 9.0 * k4)))
            angle -= excess / slope if slope > 0.0 else 0.0
            if not low < angle < high:
                angle = 0.5 * (low + high)
        scale = math.tan(angle) / radius if radius > 0.0 else 1.0
        ideal[i, 0], ideal[i, 1] = bent[i, 0] * scale, bent[i, 1] * scale
    return ideal
