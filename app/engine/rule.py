"""The form of a rule: how commands of one type are checked, carried out and repeated."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum, auto
from typing import Any

from app.engine.controls import Controls
from app.engine.program import Program
from robot.driving.odometry import OdometryState
from robot.fields.field import Field


class Repeat(Enum):
    """How a replay repeats a recorded command, and how long a viewer's own command holds there."""

    NEVER = auto()
    """Not repeated: a recording cannot be driven; or the filter does not need the command."""
    RECORDED = auto()
    """Carried out as recorded."""
    MOMENT = auto()
    """Carried out as recorded; a viewer's own command holds until somebody seeks."""
    SETTING = auto()
    """Carried out as recorded, but a viewer's own command overrides it for the whole replay."""


def nothing(*_: object) -> None:
    """Check or carry out nothing."""
    pass


@dataclass(frozen=True)
class Rule:
    """How commands of one type are checked, carried out and repeated."""

    apply: Callable[[Any, Controls, OdometryState], None]
    """Carries the command out, in the engine's thread."""
    repeat: Repeat
    check: Callable[[Any, Program], None] = nothing
    """Raises a CommandError if this robot or these parameters do not allow the command."""
    check_field: Callable[[Any, Field], None] = nothing
    """Raises a CommandError if the field does not allow it, or the numbers make no sense; replays
    ask it of recorded commands as well."""
    drives: bool = False
    """Whether the robot has to stop when everybody has left who sent such commands."""
    slow: bool = False
    """Whether it may take more than some milliseconds; an event loop leaves it to a thread."""
