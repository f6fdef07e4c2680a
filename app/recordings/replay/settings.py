"""The filter's settings in a replay: those of then, and what somebody wants to be otherwise."""

from __future__ import annotations

from collections.abc import Collection
from typing import Any

from app.engine.telling import BeliefError, cloud_of, covariance_of
from app.messages.commands import (
    Command,
    PauseCommand,
    PlaceCommand,
    ResetCommand,
    ResumeCommand,
    ScatterCommand,
    SetParametersCommand,
    SetParticlesCommand,
    SetPoseCommand,
    UpdateCommand,
)
from robot.covariance import CovarianceError
from robot.fields.field import Field
from robot.geometry import Pose2

RETOLD = (
    SetPoseCommand,
    SetParticlesCommand,
    ScatterCommand,
    PlaceCommand,
    PauseCommand,
    ResumeCommand,
    UpdateCommand,
    ResetCommand,
    SetParametersCommand,
)
"""Commands that the filter gets again; the others moved a robot that moves no more."""


class ReplaySettings:
    """What is changed during the replay holds for the whole of it, whatever was changed then."""

    def __init__(self, given: Collection[str] = ()) -> None:
        """``given`` are names of parameters that were chosen for the replay before it began."""
        self.changed: dict[str, Any] = {}
        """Parameters and models of the user's own that were chosen during the replay, by name."""
        self._given = frozenset(given)

    def change(self, command: SetParametersCommand | ResetCommand) -> None:
        """Take what somebody wants now; ``reset`` is back to the replay's beginning."""
        if isinstance(command, ResetCommand):
            self.changed = {}
        else:
            self.changed = {**self.changed, **command.values}

    def again(self, command: Command) -> tuple[Command, ...]:
        """What a command of then means in this replay."""
        match command:
            case SetParametersCommand():
                chosen = self._given | self.changed.keys()
                left = {name: v for name, v in command.values.items() if name not in chosen}
                return (command.model_copy(update={"values": left}),) if left else ()
            case ResetCommand() if self.changed:
                anew = SetParametersCommand(type="set_parameters", values=dict(self.changed))
                return command, anew
        return (command,) if isinstance(command, RETOLD) else ()


def refused(command: Command, field: Field) -> str | None:
    """Why a recorded command cannot be carried out; None if it can."""
    match command:
        case SetPoseCommand() | PlaceCommand():
            poses = [(command.x, command.y, command.theta)]
        case SetParticlesCommand():
            poses = list(command.poses)
        case _:
            return None
    if not all(field.contains(Pose2(*pose)) for pose in poses):
        return f"A recorded {command.type} is off the map."
    try:
        if isinstance(command, SetPoseCommand):
            covariance_of(command)
        elif isinstance(command, SetParticlesCommand):
            cloud_of(command)
    except (BeliefError, CovarianceError) as error:
        return f"A recorded {command.type} was not taken: {error}."
    return None
