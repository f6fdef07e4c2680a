"""Commands of the page: the layers of its 3D view, and a change to another field."""

from __future__ import annotations

from typing import TYPE_CHECKING

from app.engine.command_row import CommandRow, Part, Request, TickContext
from app.engine.driving_commands import require_drivable
from app.messages.commands import ShowCommand, UseFieldCommand

if TYPE_CHECKING:
    from app.page.program_changes import ProgramChanges

CHANGES: Part[ProgramChanges] = Part("changes")


def _show(tick: TickContext[ShowCommand]) -> None:
    command, controls = tick.command, tick.controls
    shown = {command.layer} if command.visible else set()
    controls.layers = controls.layers - {command.layer} | shown


def _use_field(request: Request[UseFieldCommand]) -> None:
    request.part(CHANGES).use_field(request.driver, request.command)


COMMANDS = (
    CommandRow(ShowCommand, _show),
    CommandRow(UseFieldCommand, act=_use_field, allowed=require_drivable, slow=True),
)
