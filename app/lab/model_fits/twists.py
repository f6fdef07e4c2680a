"""Planar motions by the thousand, and the twists that make them; odometry corrected by wheels."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robot.driving.differential_drive import WheelMultipliers
from robot.geometry import Array, wrap_angle

STRAIGHT = 1e-4
"""Turns [rad] below this are taken by their Taylor series."""


@dataclass(frozen=True, slots=True)
class DriveCorrection:
    """Truth from odometry, on the mean.

    Of a distance D and a turn W by odometry it makes

        W' = turn W + curvature D
        D' = distance D + (curvature track^2 / 4) (distance / turn) W

    which are the wheels' ways, each by a factor, over another track: with the ways
    L = D - track W / 2 and R = D + track W / 2 and the multipliers m_l, m_r and m_b,
    D' = (m_l L + m_r R) / 2 and W' = (m_r R - m_l L) / (m_b track).
    """

    distance: float = 1.0
    """True distance by that of odometry."""
    turn: float = 1.0
    """True turn by that of odometry."""
    curvature: float = 0.0
    """Turn by distance where odometry goes straight on [rad/m]."""
    track: float = 0.0
    """Distance between the wheels that odometry believes in [m]; 0 where it is not known, and the
    last term, of less than a millimetre a radian, is left out."""

    def corrected(self, steps: Array) -> Array:
        """Steps (n, 3) [m, m, rad] of odometry as they are on the mean; each is an arc."""
        x, y, turn = np.moveaxis(twists_of(steps), -1, 0)
        # Uneven wheels turn a robot about another point than the middle between them.
        aside = self.curvature * self.track**2 / 4 * self.distance / self.turn
        ahead = self.distance * x + aside * turn
        return motions_of(
            np.stack([ahead, self.distance * y, self.turn * turn + self.curvature * x], axis=-1)
        )

    def wheel_multipliers(self) -> WheelMultipliers:
        """The same as factors on radii and track, which has to be known."""
        separation = self.distance / self.turn
        half_difference = self.curvature * separation * self.track / 2
        return WheelMultipliers(
            self.distance - half_difference, self.distance + half_difference, separation
        )


def relative(start: Array, end: Array) -> Array:
    """Where poses (n, 3) are, seen from others (n, 3) [m, m, rad]."""
    offset = end - start
    c, s = np.cos(start[..., 2]), np.sin(start[..., 2])
    x, y = offset[..., 0], offset[..., 1]
    return np.stack([c * x + s * y, c * y - s * x, wrap_angle(offset[..., 2])], axis=-1)


def twists_of(motions: Array) -> Array:
    """The constant twists (n, 3) [m, m, rad] that make motions (n, 3) in a unit of time.

    The logarithm of SE(2): a robot that keeps such a twist runs along an arc of a circle.
    """
    half = motions[..., 2] / 2
    near_zero = np.abs(half) < STRAIGHT
    safe = np.where(near_zero, 1.0, half)
    along = np.where(near_zero, 1 - half * half / 3, safe / np.tan(safe))
    x, y = motions[..., 0], motions[..., 1]
    return np.stack([along * x + half * y, along * y - half * x, motions[..., 2]], axis=-1)


def motions_of(twists: Array) -> Array:
    """The motions (n, 3) [m, m, rad] of twists (n, 3) kept for a unit of time; exp of SE(2)."""
    turn = twists[..., 2]
    near_zero = np.abs(turn) < STRAIGHT
    safe = np.where(near_zero, 1.0, turn)
    along = np.where(near_zero, 1 - turn * turn / 6, np.sin(safe) / safe)
    aside = np.where(near_zero, turn / 2, (1 - np.cos(safe)) / safe)
    x, y = twists[..., 0], twists[..., 1]
    return np.stack([along * x - aside * y, aside * x + along * y, turn], axis=-1)


def chained(steps: Array) -> Array:
    """Poses (n + 1, 3) along steps (n, 3), from the origin on; headings are not wrapped."""
    headings = np.concatenate([[0.0], np.cumsum(steps[:, 2])])
    c, s = np.cos(headings[:-1]), np.sin(headings[:-1])
    poses = np.zeros((len(steps) + 1, 3))
    poses[1:, 0] = np.cumsum(c * steps[:, 0] - s * steps[:, 1])
    poses[1:, 1] = np.cumsum(s * steps[:, 0] + c * steps[:, 1])
    poses[:, 2] = headings
    return poses


def seen_from(poses: Array) -> Array:
    """Matrices (n, 3, 3) that take twists seen from the origin to those seen from poses (n, 3).

    The adjoint of the inverse pose: the same movement of a rigid body, told at another place.
    """
    x, y, theta = poses[..., 0], poses[..., 1], poses[..., 2]
    c, s = np.cos(theta), np.sin(theta)
    matrices = np.zeros((*poses.shape[:-1], 3, 3))
    matrices[..., 0, 0], matrices[..., 0, 1], matrices[..., 0, 2] = c, s, s * x - c * y
    matrices[..., 1, 0], matrices[..., 1, 1], matrices[..., 1, 2] = -s, c, s * y + c * x
    matrices[..., 2, 2] = 1.0
    return matrices
