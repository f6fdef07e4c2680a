"""Inverse of the lens distortion: from distorted to ideal image coordinates.

Newton's method inverts Brown's formula. It takes two or three steps for each point, because it
starts from the solution of the neighbour: neighbours in a picture are neighbours without distortion
too.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

FOUND = 1e-13
"""A solution, distorted again, must be this close to the given point [focal lengths]."""
STEPS = 20
"""Largest number of steps: Newton's method takes 2 to 6, or does not converge."""
NEAR = 0.05
"""A point closer than this to the previous one starts from its solution [focal lengths]."""


@njit(cache=True, nogil=True)
def undistorted(
    bent: NDArray[np.float64], distortion: NDArray[np.float64], widest: float
) -> NDArray[np.float64]:
    """Return the ideal image coordinates (n, 2) of distorted ones (n, 2); nan without a solution.

    Args:
        bent: distorted coordinates [focal lengths] from the principal point; fastest row by row.
        distortion: (5,) k1, k2, p1, p2, k3 of Brown's formula.
        widest: radius within which the formula is one-to-one; solutions beyond it are rejected.
    """
    k1, k2, p1, p2, k3 = distortion
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
            radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3))
            off_u = x * radial + 2.0 * p1 * xy + p2 * (r2 + 2.0 * xx) - u
            off_v = y * radial + p1 * (r2 + 2.0 * yy) + 2.0 * p2 * xy - v
            if abs(off_u) < FOUND and abs(off_v) < FOUND:
                result = r2 < widest * widest
                break
            # Partial derivatives of the formula; the Jacobian is symmetric.
            grows = 2.0 * (k1 + r2 * (2.0 * k2 + r2 * 3.0 * k3))
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
