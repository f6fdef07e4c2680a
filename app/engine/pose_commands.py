"""Turns pose and particle commands into checked input of the filter."""

from __future__ import annotations

import numpy as np

from app.messages.commands import SetParticlesCommand, SetPoseCommand
from robot.covariance import covariance_from
from robot.errors import CommandError
from robot.geometry import Array, wrap_angle
from robot.localization.filter import Cloud


def covariance_of(command: SetPoseCommand) -> Array | None:
    """Return the covariance (3, 3) [m, m, rad] in a pose command; None if it has none.

    Raises:
        CommandError: the command also has standard deviations.
        CovarianceError: the numbers are not a valid covariance.
    """
    if command.covariance is None:
        return None
    if command.sd_xy is not None or command.sd_theta is not None:
        raise CommandError("both covariance and standard deviations are given; valid is either")
    return covariance_from(command.covariance)


def cloud_of(command: SetParticlesCommand) -> Cloud:
    """Return the poses of a command, with weights that sum to one.

    Raises:
        CommandError: the numbers of weights and poses differ, or all weights are zero.
    """
    poses = np.array(command.poses, dtype=np.float64)
    poses[:, 2] = wrap_angle(poses[:, 2])
    if command.weights is None:
        return Cloud.even(poses)
    if len(command.weights) != len(poses):
        raise CommandError(
            f"there are {len(command.weights)} weights for {len(poses)} poses; valid is one each"
        )
    weights = np.array(command.weights, dtype=np.float64)
    largest = weights.max()
    if largest <= 0:
        raise CommandError("all weights are zero; valid is at least one above")
    weights /= largest  # so that their sum is finite
    return Cloud(poses, weights / weights.sum())
