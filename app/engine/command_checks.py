"""Commands from outside, checked before they reach the engine's queue."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from pydantic import ValidationError

from app.engine.build import Program
from app.engine.engine import Engine
from app.engine.own_models.own_models import OwnChoice
from app.engine.parameter_changes import changed_with_own
from app.engine.telling import BeliefError, cloud_of, covariance_of
from app.messages.commands import (
    COMMAND,
    Command,
    DriveCommand,
    FigureEightCommand,
    PingCommand,
    PlaceCommand,
    ReplayCommand,
    SetParametersCommand,
    SetParticlesCommand,
    SetPoseCommand,
    StopCommand,
)
from robot.covariance import CovarianceError
from robot.fields.field import Field
from robot.geometry import Pose2
from robot.interface import Placeable

LONGEST = 2_000_000
"""A longer text is no command [characters]; 20,000 poses with weights are shorter."""

MOST_WAITING = 1000
"""Commands that may wait for the engine; a flood must not fill the memory of one that hangs."""


MOST_WAITING_SETS = 20
"""A set of poses is not taken behind so many commands: it may be large."""


class CommandError(ValueError):
    """A command that cannot be carried out; the message says why, and what could."""


def parse(text: str) -> Command:
    """The command in a JSON text.

    Raises:
        CommandError: it is none; names what is wrong and what is valid.
    """
    if len(text) > LONGEST:
        raise CommandError(f"a command has at most {LONGEST} characters; this has {len(text)}")
    try:
        return COMMAND.validate_json(text)
    except ValidationError as error:
        raise CommandError(in_words(error)) from error


def check(command: Command, program: Program) -> None:
    """Refuse what this field, this robot or these parameters do not allow.

    Raises:
        CommandError: says why.
    """
    _check_engine(command, program.engine)
    _check_replay(command, program)
    match command:
        case SetPoseCommand():
            _check_on_map([(command.x, command.y, command.theta)], program.field)
            _check_belief(lambda: covariance_of(command))
        case SetParticlesCommand():
            if program.engine.commands.qsize() >= MOST_WAITING_SETS:
                raise CommandError("commands wait already; a set of poses would fill the memory")
            _check_on_map(command.poses, program.field)
            _check_belief(lambda: cloud_of(command))
        case PlaceCommand():
            _check_on_map([(command.x, command.y, command.theta)], program.field)
            if not isinstance(program.robot, Placeable):
                raise CommandError(f"{program.robot.name} can only be moved by hand")
        case DriveCommand() | FigureEightCommand():
            _check_models(program.engine)
        case SetParametersCommand():
            latest = program.engine.latest.get()
            now = latest.parameters if latest else program.config.localization
            try:
                changed_with_own(now, latest.own if latest else OwnChoice(), command.values)
            except ValueError as error:
                raise CommandError(str(error)) from error


def _check_replay(command: Command, program: Program) -> None:
    drives = isinstance(command, DriveCommand | FigureEightCommand)
    if drives and program.loop is not None:
        raise CommandError("this is a replay; only a robot that is there can be driven")
    if isinstance(command, ReplayCommand) and program.loop is None:
        raise CommandError("this is no replay; brickpose replay FILE starts one")


def _check_on_map(poses: Sequence[tuple[float, float, float]], field: Field) -> None:
    for x, y, theta in poses:
        if not field.contains(Pose2(x, y, theta)):
            xmin, ymin, xmax, ymax = field.extent
            raise CommandError(
                f"({x:g}, {y:g}) m is off the map; x is {xmin:g} to {xmax:g} "
                f"and y is {ymin:g} to {ymax:g}"
            )


def _check_belief(make: Callable[[], object]) -> None:
    try:
        make()
    except (BeliefError, CovarianceError) as error:
        raise CommandError(str(error)) from error


def _check_models(engine: Engine) -> None:
    latest = engine.latest.get()
    if latest is not None and latest.fault is not None:
        raise CommandError(f"the robot stands still until this is mended: {latest.fault}")


def _check_engine(command: Command, engine: Engine) -> None:
    if isinstance(command, PingCommand):
        return
    if engine.failure is not None:
        raise CommandError(engine.failure)
    if engine.commands.qsize() >= MOST_WAITING and not isinstance(command, StopCommand):
        raise CommandError(f"{MOST_WAITING} commands wait already; send fewer, or wait for answers")


def in_words(error: ValidationError) -> str:
    """What is wrong first, and where."""
    first = error.errors(include_url=False, include_input=False)[0]
    place = ".".join(str(part) for part in first["loc"])
    return f"{place}: {first['msg']}" if place else first["msg"]
