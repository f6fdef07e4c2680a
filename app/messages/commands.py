"""Commands to the robot and the filter, and their answers."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import AfterValidator, AwareDatetime, ConfigDict, Field, TypeAdapter, ValidationError

from app.messages.message import Layer, Message, Metres, Radians
from robot.errors import CommandError

LONGEST_ID = 200
"""Longest id of a command [characters]; the answer repeats it."""

MOST_POSES = 20_000
"""Most poses from which a filter can be started."""


def _short(name: int | str | None) -> int | str | None:
    if isinstance(name, str) and len(name) > LONGEST_ID:
        raise ValueError(f"an id has at most {LONGEST_ID} characters")
    return name


class CommandMessage(Message):
    """Base of all commands; a number must be a number, not a text or a truth value."""

    model_config = ConfigDict(strict=True)

    id: Annotated[int | str | None, AfterValidator(_short)] = None
    """Repeated in the answer."""


class DriveCommand(CommandMessage):
    """Drive; holds for 0.3 s unless renewed. Velocities beyond the limits are reduced to them."""

    type: Literal["drive"]
    v: Annotated[float, Field(ge=-10, le=10)]
    omega: Annotated[float, Field(ge=-100, le=100)]


class StopCommand(CommandMessage):
    """Stand still at once, whatever drives."""

    type: Literal["stop"]


class FigureEightCommand(CommandMessage):
    """Drive the open-loop figure-eight; holds for 0.3 s like drive, and continues if renewed."""

    type: Literal["figure_eight"]
    start: bool = False
    """Whether to begin only where it fits: it is refused if the robot would leave the field."""
    speed: Annotated[float, Field(ge=0.01, le=2)] | None = None
    """Along the circles [m/s]; null is as set. It may change on the way."""


class CalibrateCommand(CommandMessage):
    """Drive to calibrate the robot, for a minute; holds for 0.3 s, and continues if renewed.

    At its end the robot is calibrated by what it saw; ``stop`` leaves it as it was.
    """

    type: Literal["calibrate"]
    start: bool = False
    """Whether to begin; without it the command only renews a drive that has begun."""


class FinishCalibrationCommand(CommandMessage):
    """End the calibration's drive, and calibrate the robot by what it has seen so far."""

    type: Literal["finish_calibration"]


class UndoCalibrationCommand(CommandMessage):
    """Go back to the calibration before the last one by driving; a second undo takes that back."""

    type: Literal["undo_calibration"]


class StartMapCommand(CommandMessage):
    """Draw a map of the floor from now on, however the robot is driven."""

    type: Literal["start_map"]
    discard: bool = False
    """Whether a map that is drawn already is forgotten; else it is kept, and none begins."""
    paused: bool = False
    """Whether no pictures are taken into it until ``pause_map`` says so."""


class PauseMapCommand(CommandMessage):
    """Take no pictures into the map that is drawn, or take them again.

    The wheels tell the robot's way meanwhile.
    """

    type: Literal["pause_map"]
    paused: bool | None = None
    """Null is the other way than now."""


class ExploreCommand(CommandMessage):
    """Drive to see the tape that the map lacks; holds for 0.3 s, and continues if renewed.

    It ends by itself, back at its start, when all of the floor between the tape was seen.
    """

    type: Literal["explore"]
    start: bool = False
    """Whether to begin; without it the command only renews a drive that has begun."""


class FinishMapCommand(CommandMessage):
    """End the drive of the map; all of it is adjusted then."""

    type: Literal["finish_map"]


class DeleteStrokeCommand(CommandMessage):
    """Delete a stroke of tape from the finished map, before it is saved."""

    type: Literal["delete_stroke"]
    stroke: Annotated[int, Field(ge=0, le=100_000)]
    """Its number, from 0 on, in ``/api/mapping``."""
    version: int
    """Of that drawing: in another one, the stroke may have another number."""


class MoveEndCommand(CommandMessage):
    """Move an end of a stroke of the finished map, before it is saved."""

    type: Literal["move_end"]
    stroke: Annotated[int, Field(ge=0, le=100_000)]
    """Its number, from 0 on, in ``/api/mapping``."""
    last: bool
    """Whether it is the end of its last point, or that of its first."""
    x: Metres
    y: Metres
    """In the new map."""
    version: int
    """Of that drawing."""


class JoinStrokesCommand(CommandMessage):
    """Join two strokes of the finished map where their ends are nearest, before it is saved."""

    type: Literal["join_strokes"]
    stroke: Annotated[int, Field(ge=0, le=100_000)]
    other: Annotated[int, Field(ge=0, le=100_000)]
    """Their numbers, from 0 on, in ``/api/mapping``."""
    version: int
    """Of that drawing."""


class DiscardMapCommand(CommandMessage):
    """Forget the map that is drawn, or was."""

    type: Literal["discard_map"]


class SaveMapCommand(CommandMessage):
    """Save the map under a new name; the dashboard's maps have a folder.

    While it is drawn, it is saved as it is, and drawn on.
    """

    type: Literal["save_map"]
    name: Annotated[str, Field(max_length=200)]
    use: bool = False
    """Whether to go on in the new map at once, if it is finished. The robot stands meanwhile, and a
    recording ends."""


class TakeCommand(CommandMessage):
    """Take the drive from whoever has it, and end a stop that holds."""

    type: Literal["take"]


class SetPoseCommand(CommandMessage):
    """Tell the filter where the robot is, and how sure that is."""

    type: Literal["set_pose"]
    x: Metres
    y: Metres
    theta: Radians
    sd_xy: Annotated[float, Field(gt=0, le=100)] | None = None
    sd_theta: Annotated[float, Field(gt=0, le=10)] | None = None
    covariance: Annotated[list[float], Field(min_length=9, max_length=9)] | None = None
    """9 numbers by rows [m^2, m rad, rad^2], symmetric and positive semi-definite, instead of the
    standard deviations."""


class SetParticlesCommand(CommandMessage):
    """Start the filter from given poses: the robot is at or near one of them."""

    type: Literal["set_particles"]
    poses: Annotated[
        list[tuple[Metres, Metres, Radians]], Field(min_length=1, max_length=MOST_POSES)
    ]
    """x, y, theta of each pose."""
    weights: Annotated[list[Annotated[float, Field(ge=0)]], Field(max_length=MOST_POSES)] | None = (
        None
    )
    """How likely each pose is, on any scale; null is equally likely."""


class ScatterCommand(CommandMessage):
    """Spread the cloud over the whole field: the robot may be anywhere."""

    type: Literal["scatter"]


class UndoCommand(CommandMessage):
    """Take back the last set_pose, set_particles or scatter: restore what was believed before."""

    type: Literal["undo"]


class PlaceCommand(CommandMessage):
    """Put the simulated robot itself elsewhere, without telling the filter."""

    type: Literal["place"]
    x: Metres
    y: Metres
    theta: Radians


class PauseCommand(CommandMessage):
    """Stop updating the filter by measurements; odometry still moves the cloud."""

    type: Literal["pause"]


class ResumeCommand(CommandMessage):
    """Update the filter again."""

    type: Literal["resume"]


class UpdateCommand(CommandMessage):
    """Update once with the next frame, even if the filter is paused or the robot stands still."""

    type: Literal["update"]


class ResetCommand(CommandMessage):
    """Restore the filter's configured parameters, and put the cloud at the start pose."""

    type: Literal["reset"]


class SetCalibrationCommand(CommandMessage):
    """Change what is known of the robot: how it differs from its description.

    What is left out stays as it is.
    """

    type: Literal["set_calibration"]
    values: Annotated[dict[str, float], Field(min_length=1, max_length=11)]
    """Differences by name, in the units of the profile's file [rad, m, s, relative]."""
    sd: Annotated[dict[str, float], Field(max_length=11)] = Field(default_factory=dict)
    """Their standard deviations; what has none is as uncertain as in a robot built by hand."""
    made: AwareDatetime | None = None
    """When it was measured; null is when the rest was."""
    source: Annotated[str, Field(max_length=200)] = "a command"
    """What it was measured from."""


class SetParametersCommand(CommandMessage):
    """Change parameters of the filter: all or none; ``/api/parameters`` lists their names."""

    type: Literal["set_parameters"]
    values: Annotated[dict[str, float | str | bool], Field(min_length=1, max_length=64)]


class SetFaultsCommand(CommandMessage):
    """Change what is wrong with the simulated robot and its camera; the robot goes on."""

    type: Literal["set_faults"]
    values: Annotated[dict[str, float | str], Field(min_length=1, max_length=32)]
    """By name; ``/api/faults`` lists what can be wrong."""


class UseFieldCommand(CommandMessage):
    """Go on with another field: a simulated robot is on it, a real one has to be put there.

    The robot stands meanwhile, and a recording ends.
    """

    type: Literal["use_field"]
    name: Annotated[str, Field(min_length=1, max_length=200)]
    """One of ``/api/fields``, or generated- and a number."""


class ShowCommand(CommandMessage):
    """Switch a layer of the 3D view on or off; all viewers share that view."""

    type: Literal["show"]
    layer: Layer
    visible: bool


class RecordCommand(CommandMessage):
    """Start a recording, or end the running one."""

    type: Literal["record"]
    on: bool


class OpenRecordingCommand(CommandMessage):
    """Go on with a recording in place of the robot, which is let go of: its motors stop."""

    type: Literal["open_recording"]
    name: Annotated[str, Field(max_length=200)]
    """As ``/api/recordings`` has it."""


class CloseRecordingCommand(CommandMessage):
    """Go back from a recording that the page opened to the robot."""

    type: Literal["close_recording"]


class ReplayCommand(CommandMessage):
    """Change how a recording is replayed; what is left out stays as it is."""

    type: Literal["replay"]
    paused: bool | None = None
    speed: Annotated[float, Field(ge=0.05, le=50)] | None = None
    """Seconds of the recording per second."""
    position_s: Annotated[float, Field(ge=0)] | None = None
    """Go to this time since the recording's beginning."""
    step: Annotated[int, Field(ge=-1000, le=1000)] | None = None
    """Go this many pictures forward (or back, if negative), and pause."""


class PingCommand(CommandMessage):
    """Do nothing; the answer's stamp serves to align the clocks."""

    type: Literal["ping"]


Command = Annotated[
    DriveCommand
    | StopCommand
    | TakeCommand
    | FigureEightCommand
    | CalibrateCommand
    | FinishCalibrationCommand
    | UndoCalibrationCommand
    | StartMapCommand
    | ExploreCommand
    | PauseMapCommand
    | FinishMapCommand
    | DeleteStrokeCommand
    | MoveEndCommand
    | JoinStrokesCommand
    | DiscardMapCommand
    | SaveMapCommand
    | SetPoseCommand
    | SetParticlesCommand
    | ScatterCommand
    | UndoCommand
    | PlaceCommand
    | PauseCommand
    | ResumeCommand
    | UpdateCommand
    | ResetCommand
    | SetParametersCommand
    | SetCalibrationCommand
    | SetFaultsCommand
    | UseFieldCommand
    | ShowCommand
    | RecordCommand
    | ReplayCommand
    | OpenRecordingCommand
    | CloseRecordingCommand
    | PingCommand,
    Field(discriminator="type"),
]
COMMAND: TypeAdapter[Command] = TypeAdapter(Command)


class AckMessage(Message):
    """The command was accepted."""

    type: Literal["ack"] = "ack"
    id: int | str | None
    stamp: float | None
    """The robot's clock when the answer was written, to align the clocks [s]."""


class ErrorMessage(Message):
    """The command was refused, and why."""

    type: Literal["error"] = "error"
    id: int | str | None
    message: str


LONGEST_COMMAND = 2_000_000
"""Longest command [characters]; 20,000 poses with weights are shorter."""


def parse(text: str) -> Command:
    """Return the command in a JSON text.

    Raises:
        CommandError: the text is not a command; the message says what is wrong and what is valid.
    """
    if len(text) > LONGEST_COMMAND:
        raise CommandError(
            f"a command has at most {LONGEST_COMMAND} characters; this has {len(text)}"
        )
    try:
        return COMMAND.validate_json(text)
    except ValidationError as error:
        raise CommandError(in_words(error)) from error


def in_words(error: ValidationError) -> str:
    """Return the first mistake and where it is, in words."""
    first = error.errors(include_url=False, include_input=False)[0]
    path = ".".join(str(part) for part in first["loc"])
    return f"{path}: {first['msg']}" if path else first["msg"]
