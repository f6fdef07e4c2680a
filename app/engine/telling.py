"""Beliefs that the filter is told by commands, checked and made into what it takes."""

from __future__ import annotations

import numpy as np

from app.engine.localization import Localization
from app.messages.commands import SetParticlesCommand, SetPoseCommand
from robot.covariance import covariance_from
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
        BeliefError: standard deviations are told as well.
        CovarianceError: it is none.
    """
    if command.covariance is None:
        return None
    if command.sd_xy is not None or command.sd_theta is not None:
        raise BeliefError("both covariance and standard deviations are given; valid is either")
    return covariance_from(command.covariance)


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
