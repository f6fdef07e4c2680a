"""Commands that send the robot to goals, and end its journey."""

from __future__ import annotations

from typing import TYPE_CHECKING

import shapely

from app.engine.command_row import CommandRow, Part, Repeat, Request, TickContext
from app.engine.driving_commands import require_drivable
from app.engine.program import Program
from app.features.navigation.journey import RENEWAL, Journey, curve_of
from app.features.navigation.messages import (
    CancelCommand,
    GoalMessage,
    NavigateCommand,
    SetWallsCommand,
    TakePlaceCommand,
)
from app.features.navigation.walls import WALLS, polygons, walls_in
from app.languages.marking import phrase
from robot.covariance import CovarianceError, covariance_from
from robot.errors import CommandError
from robot.fields.field import Field, FieldError
from robot.geometry import Pose2
from robot.navigation.walls import Walls

if TYPE_CHECKING:
    from app.features.navigation.keeper import JourneyKeeper

SMALLEST_M2 = 1e-6
"""A smaller keep-out zone is a slip of the hand [m^2]."""
DRAWN = phrase("a map is drawn; finish or discard it to drive to a goal")
TAKEN, ONCE_S = "place taken", 1.0
"""When the last place was taken, in what controls keep; another one within this time [s] is the
same."""
KEEPER: Part[JourneyKeeper] = Part("navigation")


def _begin(request: Request[NavigateCommand]) -> None:
    """Begin a journey, and keep it up if its sender does not renew it."""
    command = request.command
    keeper = request.part(KEEPER)
    if not _starts(command):
        if keeper.map_is_drawn:
            request.arbiter.put(request.driver, CancelCommand(type="cancel"))
            raise CommandError(DRAWN)
        request.pass_on()
        return
    keeper.require_known(command)
    keeper.require_free(command.poses or ())
    request.pass_on()
    keeper.keep(None if command.renewed else request.driver, request.arbiter)


def _starts(command: NavigateCommand) -> bool:
    """Whether a command starts a journey; else it renews the one that there is."""
    return any(each is not None for each in (command.poses, command.curve, command.line))


def _navigate(tick: TickContext[NavigateCommand]) -> None:
    command, controls = tick.command, tick.controls
    starts = _starts(command)
    journey = Journey.of(command, controls.stamp) if starts else RENEWAL
    controls.driving.perform(journey, controls.stamp, start=starts)


def _cancel(tick: TickContext[CancelCommand]) -> None:
    driving = tick.controls.driving
    journey = driving.programme
    before, stamp = tick.command.before, tick.controls.stamp
    # The clock of a replay begins with the recording, and is behind that of the robot.
    if isinstance(journey, Journey) and (before is None or journey.began < min(before, stamp)):
        journey.helm.canceled = True
        driving.stop()


def _set_walls(tick: TickContext[SetWallsCommand]) -> None:
    command, controls = tick.command, tick.controls
    before = walls_in(controls.kept)
    zones = before.zones if command.zones is None else polygons(command.zones)
    said = Walls(command.tape or before.tape, zones, controls.stamp)
    if (said.tape, said.zones) != (before.tape, before.zones):
        controls.kept[WALLS] = said


def _take_place(tick: TickContext[TakePlaceCommand]) -> None:
    command, kept, stamp = tick.command, tick.controls.kept, tick.controls.stamp
    taken = kept.get(TAKEN)
    # In a replay, the journey that goes along finds the recorded place, too.
    if isinstance(taken, float) and abs(stamp - taken) < ONCE_S:
        return
    kept[TAKEN] = stamp
    tick.localization.keep_belief()
    pose = Pose2(command.x, command.y, command.theta)
    tick.localization.set_pose(pose, covariance_from(command.covariance))


def _check_place(command: TakePlaceCommand, field: Field) -> None:
    """Refuse a place that is not on the floor, and numbers that are no covariance."""
    try:
        field.require_inside(Pose2(command.x, command.y, command.theta))
        covariance_from(command.covariance)
    except (FieldError, CovarianceError) as error:
        raise CommandError(str(error)) from error


def _check_walls(command: SetWallsCommand, field: Field) -> None:
    """Refuse zones that are no areas, and such as are not on the floor."""
    for zone in command.zones or ():
        area = shapely.Polygon(zone)
        xmin, ymin, xmax, ymax = field.extent
        if not area.is_valid or area.area < SMALLEST_M2:
            raise CommandError(
                "a keep-out zone crosses itself, or is no area; valid are three corners or more, "
                "in their order around it"
            )
        if not area.intersects(shapely.box(xmin, ymin, xmax, ymax)):
            raise CommandError(
                f"a keep-out zone is beyond the field; valid is x {xmin:.3f} to {xmax:.3f}, "
                f"y {ymin:.3f} to {ymax:.3f} m"
            )


def _check(command: NavigateCommand, program: Program) -> None:
    """Refuse a goal while nothing could tell the robot where it is."""
    if sum(each is not None for each in (command.poses, command.curve, command.line)) > 1:
        raise CommandError("a journey has poses, a curve or a line; valid is one of them")
    if command.curve is not None:
        curve_of(command.curve, program.config.figure_eight)
    latest = program.engine.latest.get()
    if not _starts(command) or latest is None:
        return
    by_map = command.line is None
    if by_map and (latest.filter.paused or latest.filter.hand is not None):
        raise CommandError("the filter is paused; resume it to drive to a goal")
    if latest.drawn is not None:
        raise CommandError(DRAWN)


def _check_field(command: NavigateCommand, field: Field) -> None:
    """Refuse goals that are not on the floor."""
    curve = command.curve
    points = [GoalMessage(x=x, y=y) for x, y in curve.points] if curve else []
    for goal in [*(command.poses or ()), *points]:
        if not field.contains(Pose2(goal.x, goal.y)):
            xmin, ymin, xmax, ymax = field.extent
            raise CommandError(
                f"the goal ({goal.x:.3f}, {goal.y:.3f}) m is beyond the field; valid is x "
                f"{xmin:.3f} to {xmax:.3f}, y {ymin:.3f} to {ymax:.3f} m"
            )


COMMANDS = (
    CommandRow(
        NavigateCommand,
        _navigate,
        Repeat.RECORDED,
        act=_begin,
        allowed=require_drivable,
        check=_check,
        check_field=_check_field,
        drives=True,
    ),
    CommandRow(
        TakePlaceCommand,
        _take_place,
        Repeat.RECORDED,
        allowed=require_drivable,
        check_field=_check_place,
    ),
    CommandRow(CancelCommand, _cancel, Repeat.RECORDED, allowed=require_drivable),
    CommandRow(
        SetWallsCommand,
        _set_walls,
        Repeat.RECORDED,
        allowed=require_drivable,
        check_field=_check_walls,
    ),
)
