"""Commands to draw a map of the floor by driving, to mend and save it; and the map as drawn."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from app.messages.message import CommandMessage, Message, Metres, Radians
from robot.errors import CommandError


class NoMapError(CommandError):
    """There is no map yet, or none that is drawn now."""


class StartMapCommand(CommandMessage):
    """Start to draw a map of the floor, however the robot is driven."""

    type: Literal["start_map"]
    discard: bool = False
    """Whether to forget an unsaved map; otherwise the command is refused if there is one."""
    paused: bool = False
    """Whether to begin paused: no pictures are added until ``pause_map`` resumes."""


class PauseMapCommand(CommandMessage):
    """Stop adding pictures to the map that is drawn, or add them again.

    The wheels tell the robot's way meanwhile.
    """

    type: Literal["pause_map"]
    paused: bool | None = None
    """Null toggles."""


class ExploreCommand(CommandMessage):
    """Drive to see the tape that the map lacks.

    It holds as long as drive does, and continues if renewed. It ends by itself, back at
    its start, when the floor between the tape and around it was looked at.
    """

    type: Literal["explore"]
    start: bool = False
    """Whether to begin; without it the command only renews a drive that has begun."""


class RouteCommand(CommandMessage):
    """Drive a robot that explores to a pose: a turn on the spot, straight there, and another turn.

    The exploration gives these by itself; a robot that does not explore stands.
    """

    type: Literal["route"]
    x: Metres
    y: Metres
    theta: Radians
    """In the frame of odometry."""
    turn: Annotated[float, Field(ge=-100, le=100)] = 0.0
    """On the spot before all else, to the left [rad]; more than one turn is valid."""


class FinishMapCommand(CommandMessage):
    """End the drive of the map; all of it is adjusted then."""

    type: Literal["finish_map"]


class DeleteStrokeCommand(CommandMessage):
    """Delete a stroke of tape from the finished map, before it is saved."""

    type: Literal["delete_stroke"]
    stroke: Annotated[int, Field(ge=0, le=100_000)]
    """Its number, from 0 on, in ``/api/mapping``."""
    version: int
    """Version of that drawing; in another one, the stroke may have another number."""


class MoveEndCommand(CommandMessage):
    """Move an end of a stroke of the finished map, before it is saved."""

    type: Literal["move_end"]
    stroke: Annotated[int, Field(ge=0, le=100_000)]
    """Its number, from 0 on, in ``/api/mapping``."""
    last: bool
    """Whether it is the end at the last point, or the one at the first."""
    x: Metres
    y: Metres
    """Where to, in the new map [m]."""
    version: int
    """Version of that drawing."""


class JoinStrokesCommand(CommandMessage):
    """Join two strokes of the finished map where their ends are nearest, before it is saved."""

    type: Literal["join_strokes"]
    stroke: Annotated[int, Field(ge=0, le=100_000)]
    other: Annotated[int, Field(ge=0, le=100_000)]
    """Their numbers, from 0 on, in ``/api/mapping``."""
    version: int
    """Of that drawing."""


class UndoEditCommand(CommandMessage):
    """Take back the last change of the finished map, before it is saved."""

    type: Literal["undo_edit"]
    version: int
    """Of that drawing."""


class DiscardMapCommand(CommandMessage):
    """Forget the map."""

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
    force: bool = False
    """Whether a map is saved that contradicts itself."""


class StrokeMessage(Message):
    """The centre line of a piece of tape."""

    points: list[tuple[float, float]]
    """Points along it [m]; a closed line repeats its first point."""
    interval: float
    """Half of the 95 % interval across the line, where it is least certain [m]."""


class MapDrawingMessage(Message):
    """The map that is drawn by driving, as far as it is drawn."""

    version: int
    """Its version, as in ``MappingMessage``; 0 without a map."""
    strokes: list[StrokeMessage]
    path: list[tuple[float, float]]
    """The robot's path, corrected [m]."""
    edges: list[tuple[float, float]]
    """Some of the points at which edges of tape were seen [m]."""
    unseen_ends: list[tuple[float, float]]
    """In a finished map, ends of strokes that no picture showed [m]."""
    facts: list[str]
    """How well a finished map fits; empty before."""
    remarks: list[str]
    """What is wrong with a finished map, or may be wrong."""
    changes: int
    """How many changes of a finished map can be taken back."""
    contradictory: bool = False
    """Whether a finished map contradicts itself: it is saved only if that is asked for."""


MESSAGES = (MapDrawingMessage,)
