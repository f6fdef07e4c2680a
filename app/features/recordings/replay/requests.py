"""Requests of viewers to a replay: pause, speed, position, and other settings of the filter."""

from __future__ import annotations

import threading
from collections.abc import Collection
from dataclasses import dataclass
from typing import Any

from app.engine.command_row import Repeat
from app.engine.commands import row_of
from app.messages.commands import Command, ResetCommand, SetParametersCommand
from robot.errors import CommandError
from robot.fields.field import Field

SLOWEST, FASTEST = 0.05, 50.0
"""Limits of the speed: seconds of the recording in one second."""


@dataclass(slots=True)
class Requests:
    """The requests since they were last taken; None means no request."""

    paused: bool | None = None
    speed: float | None = None
    position_s: float | None = None
    steps: int = 0
    """Pictures to step forward; negative to step back."""


class RequestMailbox:
    """Collects requests until the replay takes them."""

    def __init__(self) -> None:
        self._wishes = Requests()
        self._changed = threading.Condition()
        self._some = False

    def ask(
        self,
        paused: bool | None = None,
        speed: float | None = None,
        position_s: float | None = None,
        step: int | None = None,
    ) -> None:
        """Add requests; a new position cancels steps that were not taken yet."""
        with self._changed:
            requests = self._wishes
            requests.paused = requests.paused if paused is None else paused
            if speed is not None:
                requests.speed = min(max(speed, SLOWEST), FASTEST)
            if position_s is not None:
                requests.position_s, requests.steps = position_s, 0
            if step is not None:
                requests.steps += step
            self._some = True
            self._changed.notify_all()

    def take(self) -> Requests:
        """Take all requests since the last call."""
        with self._changed:
            requests, self._wishes, self._some = self._wishes, Requests(), False
        return requests

    def wait(self, seconds: float) -> bool:
        """Wait for a request, at most some seconds; return whether there is one."""
        with self._changed:
            return self._changed.wait_for(lambda: self._some, max(seconds, 0.0))


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
        return () if row_of(command).repeat is Repeat.NEVER else (command,)


def refused(command: Command, field: Field) -> str | None:
    """Why a recorded command cannot be carried out; None if it can."""
    try:
        row_of(command).check_field(command, field)
    except CommandError as error:
        return f"A recorded {command.kind} was not taken: {error}."
    return None
