"""Table 5.6: sample the odometry motion model."""

from __future__ import annotations

import numpy as np

from robot.geometry import Array, Pose2, wrap_angle


def sample_motion_model_odometry(
    poses: Array,
    moved: Pose2,
    alphas: tuple[float, float, float, float],
    rng: np.random.Generator,
) -> Array:
    """Return (n, 3) poses after a step, each drawn at random.

    Args:
        poses: (n, 3) [m, m, rad] before the step.
        moved: the step by odometry, seen from its start; the book writes it as two poses.
        alphas: alpha1 to alpha4 as shares of variances, as in the book's table and in nav2.
        rng: source of the random numbers.
    """
    alpha1, alpha2, alpha3, alpha4 = alphas
    n = len(poses)

    rot1 = np.arctan2(moved.y, moved.x)
    trans = np.hypot(moved.x, moved.y)
    rot2 = wrap_angle(moved.theta - rot1)

    rot1_hat = rot1 - rng.normal(0, np.sqrt(alpha1 * rot1**2 + alpha2 * trans**2), n)
    trans_hat = trans - rng.normal(0, np.sqrt(alpha3 * trans**2 + alpha4 * (rot1**2 + rot2**2)), n)
    rot2_hat = rot2 - rng.normal(0, np.sqrt(alpha1 * rot2**2 + alpha2 * trans**2), n)

    x, y, theta = poses.T
    return np.column_stack(
        [
            x + trans_hat * np.cos(theta + rot1_hat),
            y + trans_hat * np.sin(theta + rot1_hat),
            np.array([wrap_angle(angle) for angle in theta + rot1_hat + rot2_hat]),
        ]
    )
