"""The filter's settings in a replay: the recorded settings plus the viewer's changes."""

from __future__ import annotations

from collections.abc import Collection
from typing import Any

from app.engine.commands import RULES, Repeat
from app.messages.commands import Command, ResetCommand, SetParametersCommand
from robot.errors import CommandError
from robot.fields.field import Field


class ReplaySettings:
    """A change during the replay holds for the whole replay, and overrides recorded changes."""

    def __init__(self, given: Collection[str] = ()) -> None:
        """``given`` are the names of parameters that were chosen before the replay began."""
        self.changed: dict[str, Any] = {}
        """Parameters and the user's own models that were chosen during the replay, by name."""
        self._given = frozenset(given)

    def change(self, command: SetParametersCommand | ResetCommand) -> None:
        """Take a viewer's change; ``reset`` undoes all changes since the replay began."""
        if isinstance(command, ResetCommand):
            self.changed = {}
        else:
            self.changed = {**self.changed, **command.values}

    def repeated(self, command: Command) -> tuple[Command, ...]:
        """Return the commands that repeat a recorded command in this replay."""
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
