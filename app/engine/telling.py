"""Beliefs that the filter is told by commands, checked and made into what it takes."""

from __future__ import annotations

import numpy as np

from app.engine.localization import Localization
from app.messages.commands import SetParticlesCommand, SetPoseCommand
from robot.geometry import Array, Pose2, wrap_angle
from robot.localization.filter import Cloud


class BeliefError(ValueError):
    """What is told is no belief; the message says what would be."""


def tell(localization: Localization, command: SetPoseCommand | SetParticlesCommand) -> None:
    """Start the filter anew from what a checked command says."""
    if isinstance(command, SetParticlesCommand):
        localization.set_cloud(cloud_of(command))
        return
    pose, covariance = Pose2(command.x, command.y, command.theta), covariance_of(command)
    if covariance is None:
        localization.set_pose(pose, command.sd_xy, command.sd_theta)
    else:
        localization.set_pose_with(pose, covariance)


def covariance_of(command: SetPoseCommand) -> Array | None:
    """The covariance (3, 3) [m, m, rad] that a pose is told with; None if it is without.

    Raises:
        BeliefError: it is none, or standard deviations are told as well.
    """
    if command.covariance is None:
        return None
    if command.sd_xy is not None or command.sd_theta is not None:
        raise BeliefError("both covariance and standard deviations are given; valid is either")
    return checked_covariance(command.covariance)


def checked_covariance(numbers: list[float] | tuple[float, ...]) -> Array:
    """Nine numbers by rows as a covariance (3, 3).

    Raises:
        BeliefError: they are no covariance.
    """
    if len(numbers) != 9:
        raise BeliefError(f"covariance has {len(numbers)} numbers; valid are 9, by rows")
    matrix = np.array(numbers, dtype=np.float64).reshape(3, 3)
    if not np.isfinite(matrix).all() or np.abs(matrix).max() > 1e4:
        raise BeliefError("covariance has numbers beyond 10000; valid are smaller ones")
    # What was written with six digits is as good as symmetric.
    if not np.allclose(matrix, matrix.T, rtol=1e-5, atol=1e-12):
        raise BeliefError("covariance is not symmetric; valid has c[i][j] = c[j][i]")
    even: Array = (matrix + matrix.T) / 2
    values = np.linalg.eigvalsh(even)
    if values[0] < -1e-6 * max(values[-1], 1e-9):
        raise BeliefError(
            f"covariance is not positive semi-definite: an eigenvalue is {values[0]:.3g}"
        )
    return even


def cloud_of(command: SetParticlesCommand) -> Cloud:
    """The given poses, with weights that sum to one.

    Raises:
        BeliefError: there are not as many weights as poses, or they are all zero.
    """
    poses = np.array(command.poses, dtype=np.float64)
    poses[:, 2] = wrap_angle(poses[:, 2])
    if command.weights is None:
        return Cloud.even(poses)
    if len(command.weights) != len(poses):
        raise BeliefError(
            f"there are {len(command.weights)} weights for {len(poses)} poses; valid is one each"
        )
    weights = np.array(command.weights, dtype=np.float64)
    largest = weights.max()
    if largest <= 0:
        raise BeliefError("all weights are zero; valid is at least one above")
    weights /= largest  # so that their sum is finite
    return Cloud(poses, weights / weights.sum())
