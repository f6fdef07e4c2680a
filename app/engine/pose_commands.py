"""Checks and carries out commands of where the robot is, or where the filter believes it to be."""

from __future__ import annotations

import numpy as np

from app.engine.controls import Controls
from app.engine.program import Program
from app.messages.commands import Command, PlaceCommand, SetParticlesCommand, SetPoseCommand
from robot.covariance import CovarianceError, covariance_from
from robot.driving.odometry import OdometryState
from robot.errors import CommandError
from robot.fields.field import Field
from robot.geometry import Array, Pose2, wrap_angle
from robot.interface import RepositionableRobot
from robot.localization.filter import Cloud

MOST_WAITING_SETS = 20
"""A set of poses is refused if this many commands wait already: it may be large."""


def set_pose(command: SetPoseCommand, controls: Controls, _odometry: OdometryState) -> None:
    """Start the filter at a pose."""
    controls.localization.keep_belief()
    pose, covariance = Pose2(command.x, command.y, command.theta), covariance_of(command)
    if covariance is None:
        controls.localization.set_pose(pose, command.sd_xy, command.sd_theta)
    else:
        controls.localization.set_pose_with(pose, covariance)


def check_pose(command: SetPoseCommand, field: Field) -> None:
    """Refuse a pose off the map, and numbers that are no covariance."""
    _require_inside(Pose2(command.x, command.y, command.theta), field)
    try:
        covariance_of(command)
    except CovarianceError as error:
        raise CommandError(str(error)) from error


def set_particles(
    command: SetParticlesCommand, controls: Controls, _odometry: OdometryState
) -> None:
    """Start the filter from poses."""
    controls.localization.keep_belief()
    controls.localization.set_cloud(cloud_of(command))


def check_room(_command: SetParticlesCommand, program: Program) -> None:
    """Refuse many poses while commands wait."""
    if len(program.engine.commands) >= MOST_WAITING_SETS:
        raise CommandError("commands wait already; a set of poses would fill the memory")


def check_particles(command: SetParticlesCommand, field: Field) -> None:
    """Refuse poses off the map, and weights that do not fit them."""
    for pose in command.poses:
        _require_inside(Pose2(*pose), field)
    cloud_of(command)


def place(command: PlaceCommand, controls: Controls, odometry: OdometryState) -> None:
    """Put the simulated robot elsewhere."""
    controls.place(Pose2(command.x, command.y, command.theta), odometry)


def check_placeable(_command: PlaceCommand, program: Program) -> None:
    """Refuse to move a real robot."""
    if not isinstance(program.robot, RepositionableRobot):
        raise CommandError(f"{program.robot.name} can only be moved by hand")


def check_inside(command: PlaceCommand, field: Field) -> None:
    """Refuse a place off the map."""
    _require_inside(Pose2(command.x, command.y, command.theta), field)


def _require_inside(pose: Pose2, field: Field) -> None:
    if not field.contains(pose):
        xmin, ymin, xmax, ymax = (1000.0 * edge for edge in field.extent)
        raise CommandError(
            f"x {1000.0 * pose.x:.0f} mm, y {1000.0 * pose.y:.0f} mm is off the map; x is "
            f"{xmin:.0f} to {xmax:.0f} mm and y is {ymin:.0f} to {ymax:.0f} mm"
        )


def scatter(_command: Command, controls: Controls, _odometry: OdometryState) -> None:
    """Spread the belief over the whole field."""
    controls.localization.keep_belief()
    controls.localization.scatter()


def undo(_command: Command, controls: Controls, _odometry: OdometryState) -> None:
    """Restore what was believed before, if there is something."""
    if controls.localization.undoable:
        controls.localization.undo()
    else:
        controls.problems.note(controls.stamp, "There was nothing to undo.")


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
