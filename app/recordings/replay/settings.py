"""The filter's settings in a replay: those of then, and what somebody wants to be otherwise."""

from __future__ import annotations

from collections.abc import Collection
from typing import Any

from app.engine.commands import RULES, Repeat
from app.messages.commands import Command, ResetCommand, SetParametersCommand
from app.messages.parsing import CommandError
from robot.fields.field import Field


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
                set_parameters_command = SetParametersCommand(
                    type="set_parameters", values=dict(self.changed)
                )
                return command, set_parameters_command
        return () if RULES[type(command)].repeat is Repeat.NEVER else (command,)


def refused(command: Command, field: Field) -> str | None:
    """Why a recorded command cannot be carried out; None if it can."""
    try:
        RULES[type(command)].check_field(command, field)
    except CommandError as error:
        return f"A recorded {command.type} was not taken: {error}."
    return None
