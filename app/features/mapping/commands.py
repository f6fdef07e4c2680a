"""Commands that draw a map of the floor, mend it, and let the robot explore."""

from __future__ import annotations

from typing import TYPE_CHECKING

from app.engine.command_row import CommandRow, Part, Repeat, Request, TickContext
from app.engine.driving_commands import require_drivable
from app.engine.program import Program
from app.features.mapping.messages import (
    DeleteStrokeCommand,
    DiscardMapCommand,
    ExploreCommand,
    FinishMapCommand,
    JoinStrokesCommand,
    MoveEndCommand,
    PauseMapCommand,
    RouteCommand,
    SaveMapCommand,
    StartMapCommand,
    UndoEditCommand,
)
from robot.driving.route import Route
from robot.errors import CommandError
from robot.geometry import Pose2

if TYPE_CHECKING:
    from app.features.mapping.map_drawer import MapDrawer
    from app.features.mapping.map_saver import MapSaver

DRAWER: Part[MapDrawer] = Part("map drawer")
SAVER: Part[MapSaver] = Part("map saver")


def _require_tape(program: Program) -> None:
    """Refuse to draw a map if the scans do not come from tape."""
    require_drivable(program)
    if program.field.tape_width is None:
        raise CommandError(f"the field {program.field.name} is not of tape; maps are of tape")


def _start(request: Request[StartMapCommand]) -> None:
    command = request.command
    request.part(DRAWER).begin(discard=command.discard, paused=command.paused)


def _pause(request: Request[PauseMapCommand]) -> None:
    request.part(DRAWER).pause(request.command.paused)


def _finish(request: Request[FinishMapCommand]) -> None:
    request.part(DRAWER).finish()


def _delete_stroke(request: Request[DeleteStrokeCommand]) -> None:
    request.part(DRAWER).delete_stroke(request.command.stroke, request.command.version)


def _move_end(request: Request[MoveEndCommand]) -> None:
    command = request.command
    place = command.x, command.y
    request.part(DRAWER).move_end(command.stroke, command.last, place, command.version)


def _join_strokes(request: Request[JoinStrokesCommand]) -> None:
    command = request.command
    request.part(DRAWER).join_strokes(command.stroke, command.other, command.version)


def _undo(request: Request[UndoEditCommand]) -> None:
    request.part(DRAWER).undo_edit(request.command.version)


def _save(request: Request[SaveMapCommand]) -> None:
    request.part(SAVER).save(request.driver, request.command)


def _discard(request: Request[DiscardMapCommand]) -> None:
    request.part(DRAWER).discard()


def _begin_exploring(request: Request[ExploreCommand]) -> None:
    """Explore what the map lacks, and begin a map if there is none."""
    if request.command.start:
        request.arbiter.require_free(request.driver)
        request.part(DRAWER).explore()
    request.pass_on()


def _explore(tick: TickContext[ExploreCommand]) -> None:
    tick.controls.driving.explore(tick.controls.stamp, start=tick.command.start)


def _follow(tick: TickContext[RouteCommand]) -> None:
    command = tick.command
    goal = Pose2(command.x, command.y, command.theta)
    tick.controls.driving.route = Route(goal, command.turn)


COMMANDS = (
    CommandRow(StartMapCommand, act=_start, allowed=_require_tape, slow=True),
    CommandRow(PauseMapCommand, act=_pause, allowed=require_drivable),
    CommandRow(
        ExploreCommand, _explore, act=_begin_exploring, allowed=require_drivable, drives=True
    ),
    CommandRow(RouteCommand, _follow, Repeat.RECORDED, allowed=require_drivable, drives=True),
    CommandRow(FinishMapCommand, act=_finish, allowed=require_drivable),
    CommandRow(DeleteStrokeCommand, act=_delete_stroke, allowed=require_drivable, slow=True),
    CommandRow(MoveEndCommand, act=_move_end, allowed=require_drivable, slow=True),
    CommandRow(JoinStrokesCommand, act=_join_strokes, allowed=require_drivable, slow=True),
    CommandRow(UndoEditCommand, act=_undo, allowed=require_drivable, slow=True),
    CommandRow(SaveMapCommand, act=_save, allowed=require_drivable, slow=True),
    CommandRow(DiscardMapCommand, act=_discard, allowed=require_drivable, slow=True),
)
