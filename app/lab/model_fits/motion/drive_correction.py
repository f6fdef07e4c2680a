"""What odometry gets wrong each time: factors of distance and turn, and a constant curvature."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from app.lab.model_fits.motion.twists import motions_of, twists_of
from robot.driving.differential_drive import WheelMultipliers
from robot.geometry import Array


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

    @classmethod
    def of_wheels(cls, wheels: WheelMultipliers, track: float) -> DriveCorrection:
        """What odometry needs that was reckoned without the multipliers; track [m] as described."""
        mean = (wheels.left_radius + wheels.right_radius) / 2
        curvature = (wheels.right_radius - wheels.left_radius) / (wheels.separation * track)
        return cls(mean, mean / wheels.separation, curvature, track)

    def corrected(self, steps: Array) -> Array:
        """Steps (n, 3) [m, m, rad] of odometry as they are on the mean; each is an arc."""
        x, y, turn = np.moveaxis(twists_of(steps), -1, 0)
        ahead = self.distance * x + self._ahead_by_turn * turn
        return motions_of(
            np.stack([ahead, self.distance * y, self.turn * turn + self.curvature * x], axis=-1)
        )

    def wheel_multipliers(self, track: float | None = None) -> WheelMultipliers:
        """The same as factors on radii and track; the track [m] is asked if it is not known here.

        Raises:
            ValueError: no track is known.
        """
        believed = self.track if track is None else track
        if not believed > 0:
            raise ValueError("the track is not known; wheel multipliers need it, in metres")
        separation = self.distance / self.turn
        half_difference = self.curvature * separation * believed / 2
        return WheelMultipliers(
            self.distance - half_difference, self.distance + half_difference, separation
        )

    @property
    def _ahead_by_turn(self) -> float:
        """The middle between the wheels is not what a robot with uneven wheels turns about."""
        return self.curvature * self.track**2 / 4 * self.distance / self.turn
