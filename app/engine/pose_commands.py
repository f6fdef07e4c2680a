"""Commands of where the robot is, or where the filter believes it to be."""

from __future__ import annotations

import numpy as np

from app.engine.command_row import CommandRow, Repeat, TickContext
from app.engine.program import Program
from app.messages.commands import (
    PlaceCommand,
    ScatterCommand,
    SetParticlesCommand,
    SetPoseCommand,
    UndoCommand,
)
from robot.covariance import CovarianceError, covariance_from
from robot.errors import CommandError
from robot.fields.field import Field
from robot.geometry import Array, Pose2, wrap_angle
from robot.localization.filter import Cloud
from robot.localization.parameters import FilterParameters

MOST_WAITING_SETS = 20
"""A set of poses is refused if this many commands wait already: it may be large."""


def covariance_of(command: SetPoseCommand, usual: FilterParameters) -> Array:
    """Return the covariance (3, 3) [m, m, rad] that a pose command means.

    Args:
        command: has a covariance, standard deviations, or neither.
        usual: has the standard deviations that the command leaves out.

    Raises:
        CommandError: the command has both.
        CovarianceError: its numbers are not a valid covariance.
    """
    if command.covariance is None:
        xy = usual.initial_sd_xy if command.sd_xy is None else command.sd_xy
        theta = usual.initial_sd_theta if command.sd_theta is None else command.sd_theta
        return np.diag(np.square([xy, xy, theta]))
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


def _set_pose(tick: TickContext[SetPoseCommand]) -> None:
    localization, command = tick.localization, tick.command
    localization.keep_belief()
    covariance = covariance_of(command, localization.parameters.filter)
    localization.set_pose(Pose2(command.x, command.y, command.theta), covariance)


def _check_pose(command: SetPoseCommand, field: Field) -> None:
    """Refuse a pose off the map, and numbers that are no covariance."""
    _require_inside(Pose2(command.x, command.y, command.theta), field)
    try:
        covariance_of(command, FilterParameters())
    except CovarianceError as error:
        raise CommandError(str(error)) from error


def _set_particles(tick: TickContext[SetParticlesCommand]) -> None:
    tick.localization.keep_belief()
    tick.localization.set_cloud(cloud_of(tick.command))


def _require_room(program: Program) -> None:
    """Refuse many poses while commands wait."""
    if len(program.engine.commands) >= MOST_WAITING_SETS:
        raise CommandError("commands wait already; a set of poses would fill the memory")


def _check_particles(command: SetParticlesCommand, field: Field) -> None:
    """Refuse poses off the map, and weights that do not fit them."""
    for pose in command.poses:
        _require_inside(Pose2(*pose), field)
    cloud_of(command)


def _place(tick: TickContext[PlaceCommand]) -> None:
    command = tick.command
    tick.controls.place(Pose2(command.x, command.y, command.theta), tick.odometry)


def _require_placeable(program: Program) -> None:
    """Refuse to move a real robot."""
    if not program.facts.can_be_placed:
        raise CommandError(f"{program.robot.name} can only be moved by hand")


def _check_inside(command: PlaceCommand, field: Field) -> None:
    _require_inside(Pose2(command.x, command.y, command.theta), field)


def _require_inside(pose: Pose2, field: Field) -> None:
    if not field.contains(pose):
        xmin, ymin, xmax, ymax = (1000.0 * edge for edge in field.extent)
        raise CommandError(
            f"x {1000.0 * pose.x:.0f} mm, y {1000.0 * pose.y:.0f} mm is off the map; x is "
            f"{xmin:.0f} to {xmax:.0f} mm and y is {ymin:.0f} to {ymax:.0f} mm"
        )


def _scatter(tick: TickContext[ScatterCommand]) -> None:
    tick.localization.keep_belief()
    tick.localization.scatter()


def _undo(tick: TickContext[UndoCommand]) -> None:
    """Restore what was believed before, if there is something."""
    if len(tick.localization.earlier):
        tick.localization.undo()
    else:
        tick.controls.problems.note(tick.controls.stamp, "There was nothing to undo.")


COMMANDS = (
    CommandRow(SetPoseCommand, _set_pose, Repeat.MOMENT, check_field=_check_pose),
    CommandRow(
        SetParticlesCommand,
        _set_particles,
        Repeat.MOMENT,
        allowed=_require_room,
        check_field=_check_particles,
    ),
    CommandRow(ScatterCommand, _scatter, Repeat.MOMENT),
    CommandRow(UndoCommand, _undo, Repeat.MOMENT),
    CommandRow(
        PlaceCommand,
        _place,
        Repeat.RECORDED,
        allowed=_require_placeable,
        check_field=_check_inside,
    ),
)
