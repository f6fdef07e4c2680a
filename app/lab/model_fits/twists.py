"""Arrays of planar motions and of their twists, and the correction of odometry."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robot.driving.differential_drive import WheelMultipliers
from robot.geometry import Array, wrap_angle

STRAIGHT = 1e-4
"""Below this turn [rad] the Taylor series is used."""


@dataclass(frozen=True, slots=True)
class DriveCorrection:
    """Correction of odometry's systematic errors.

    From a distance D and a turn W by odometry it computes

        W' = turn W + curvature D
        D' = distance D + (curvature track^2 / 4) (distance / turn) W

    This is the same as a factor on the path of each wheel and another track: with the paths
    L = D - track W / 2 and R = D + track W / 2 and the multipliers m_l, m_r and m_b,
    D' = (m_l L + m_r R) / 2 and W' = (m_r R - m_l L) / (m_b track).
    """

    distance: float = 1.0
    """True distance divided by that of odometry."""
    turn: float = 1.0
    """True turn divided by that of odometry."""
    curvature: float = 0.0
    """True turn per distance where odometry goes straight [rad/m]."""
    track: float = 0.0
    """Distance between the wheels that odometry assumes [m]. If it is not known, it is 0, and the
    last term, of less than a millimetre per radian, is left out."""

    def corrected(self, steps: Array) -> Array:
        """Return corrected steps (n, 3) [m, m, rad] of odometry; each is an arc."""
        x, y, turn = np.moveaxis(twists_of(steps), -1, 0)
        # Unequal wheels turn a robot about a point beside the middle between them.
        aside = self.curvature * self.track**2 / 4 * self.distance / self.turn
        ahead = self.distance * x + aside * turn
        return motions_of(
            np.stack([ahead, self.distance * y, self.turn * turn + self.curvature * x], axis=-1)
        )

    def wheel_multipliers(self) -> WheelMultipliers:
        """Return the same as factors on the wheel radii and the track; the track must be known."""
        separation = self.distance / self.turn
        half_difference = self.curvature * separation * self.track / 2
        return WheelMultipliers(
            self.distance - half_difference, self.distance + half_difference, separation
        )


def relative(start: Array, end: Array) -> Array:
    """Return the end poses (n, 3) seen from the start poses (n, 3) [m, m, rad]."""
    offset = end - start
    c, s = np.cos(start[..., 2]), np.sin(start[..., 2])
    x, y = offset[..., 0], offset[..., 1]
    return np.stack([c * x + s * y, c * y - s * x, wrap_angle(offset[..., 2])], axis=-1)


def twists_of(motions: Array) -> Array:
    """Return the constant twists (n, 3) [m, m, rad] that make motions (n, 3) in a unit of time.

    This is the logarithm of SE(2): with a constant twist a robot moves along an arc.
    """
    half = motions[..., 2] / 2
    near_zero = np.abs(half) < STRAIGHT
    safe = np.where(near_zero, 1.0, half)
    along = np.where(near_zero, 1 - half * half / 3, safe / np.tan(safe))
    x, y = motions[..., 0], motions[..., 1]
    return np.stack([along * x + half * y, along * y - half * x, motions[..., 2]], axis=-1)


def motions_of(twists: Array) -> Array:
    """Return the motions (n, 3) [m, m, rad] of twists (n, 3) in a unit of time (exp of SE(2))."""
    turn = twists[..., 2]
    near_zero = np.abs(turn) < STRAIGHT
    safe = np.where(near_zero, 1.0, turn)
    along = np.where(near_zero, 1 - turn * turn / 6, np.sin(safe) / safe)
    aside = np.where(near_zero, turn / 2, (1 - np.cos(safe)) / safe)
    x, y = twists[..., 0], twists[..., 1]
    return np.stack([along * x - aside * y, aside * x + along * y, turn], axis=-1)


def chained(steps: Array) -> Array:
    """Chain steps (n, 3) to poses (n + 1, 3) from the origin on; headings are not wrapped."""
    headings = np.concatenate([[0.0], np.cumsum(steps[:, 2])])
    c, s = np.cos(headings[:-1]), np.sin(headings[:-1])
    poses = np.zeros((len(steps) + 1, 3))
    poses[1:, 0] = np.cumsum(c * steps[:, 0] - s * steps[:, 1])
    poses[1:, 1] = np.cumsum(s * steps[:, 0] + c * steps[:, 1])
    poses[:, 2] = headings
    return poses


def seen_from(poses: Array) -> Array:
    """Return matrices (n, 3, 3) that convert twists seen from the origin to those seen from poses.

    They are the adjoints of the inverse poses (n, 3): the same movement of a rigid body in another
    frame.
    """
    x, y, theta = poses[..., 0], poses[..., 1], poses[..., 2]
    c, s = np.cos(theta), np.sin(theta)
    matrices = np.zeros((*poses.shape[:-1], 3, 3))
    matrices[..., 0, 0], matrices[..., 0, 1], matrices[..., 0, 2] = c, s, s * x - c * y
    matrices[..., 1, 0], matrices[..., 1, 1], matrices[..., 1, 2] = -s, c, s * y + c * x
    matrices[..., 2, 2] = 1.0
    return matrices
