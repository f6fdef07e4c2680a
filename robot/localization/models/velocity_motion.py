"""Velocity motion model: an arc driven with an uncertain speed and an uncertain turn."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from robot.geometry import Array, Pose2
from robot.localization.kernels.steps import turn_go_turn
from robot.localization.models.odometry_motion import Legs, spread_of


@dataclass(frozen=True, slots=True)
class VelocityMotion:
    """Velocity motion model (Probabilistic Robotics, Table 5.3).

    v, omega and the final rotation gamma err with variances alpha1 v^2 + alpha2 omega^2,
    alpha3 v^2 + alpha4 omega^2 and alpha5 v^2 + alpha6 omega^2. All are multiplied by the duration
    of the step, which cancels: here v is the distance along the arc, and omega its turn. The part
    of a step by odometry that is not an arc has no error.
    """

    alpha1: float
    """Variance of v by v squared [m^2/m^2]."""
    alpha2: float
    """Variance of v by omega squared [m^2/rad^2]."""
    alpha3: float
    """Variance of omega by v squared [rad^2/m^2]."""
    alpha4: float
    """Variance of omega by omega squared [rad^2/rad^2]."""
    alpha5: float
    """Variance of gamma by v squared [rad^2/m^2]."""
    alpha6: float
    """Variance of gamma by omega squared [rad^2/rad^2]."""

    def sample(self, poses: Array, moved: Pose2, rng: np.random.Generator) -> Array:
        """Draw the pose of each particle after the step."""
        v, aside = _arc(moved)
        noise = rng.standard_normal((3, len(poses)))
        v_hat, omega_hat, gamma_hat = (
            np.array([[v], [moved.theta], [0.0]])
            + self._deviations(v, moved.theta)[:, None] * noise
        )
        # An arc is half of its turn, its chord, and the other half of its turn.
        half = omega_hat / 2
        chord = v_hat * np.sinc(half / math.pi)
        return turn_go_turn(poses, half, chord, np.full(len(poses), aside), half + gamma_hat)

    def moments(self, moved: Pose2) -> tuple[Pose2, Array]:
        """Return mean and covariance (3, 3) [m, m, rad] of the step's end, seen from its start."""
        v, aside = _arc(moved)
        half = moved.theta / 2
        sinc = float(np.sinc(half / math.pi))
        # Derivative of the chord by the half turn; near zero by its Taylor series.
        grows = -half / 3 if abs(half) < 1e-4 else (math.cos(half) - sinc) / half
        # Jacobian of turn, chord, distance aside and last turn by v, omega and gamma.
        G = np.array([[0, 0.5, 0], [sinc, v * grows / 2, 0], [0, 0, 0], [0, 0.5, 1]])
        variances = np.diag(np.square(self._deviations(v, moved.theta)))
        return moved, spread_of(Legs(half, v * sinc, aside, half), G @ variances @ G.T)

    def _deviations(self, v: float, omega: float) -> Array:
        return np.sqrt(
            [
                self.alpha1 * v**2 + self.alpha2 * omega**2,
                self.alpha3 * v**2 + self.alpha4 * omega**2,
                self.alpha5 * v**2 + self.alpha6 * omega**2,
            ]
        )


def _arc(moved: Pose2) -> tuple[float, float]:
    """Return the distance along the arc of the step, and the end's distance to its left [m]."""
    ahead, aside = Pose2(theta=-moved.theta / 2).apply(np.array([[moved.x, moved.y]]))[0]
    return float(ahead / np.sinc(moved.theta / 2 / math.pi)), float(aside)
