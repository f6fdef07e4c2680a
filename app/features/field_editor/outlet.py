"""The outlet: serves fields of one's own, and tells what of a drawing is not on the floor."""

from __future__ import annotations

from collections.abc import Iterable

from fastapi import APIRouter

from app.console import say
from app.features.field_editor.routes import field_editor_router
from app.page.outlets import Outlet, Outlets
from robot.fields.drawing.question import LEFT_OUT


class FieldEditorOutlet(Outlet):
    """Fields of one's own, as long as a program runs."""

    def __init__(self, outlets: Outlets) -> None:
        """Prepare for a program."""
        self._program = outlets.program

    def routers(self) -> Iterable[APIRouter]:
        """Return the routes that list, keep, edit and print fields."""
        return (field_editor_router(self._program),)

    def start(self) -> None:
        """Say on the terminal what of the drawing is left out."""
        field = self._program.field
        if LEFT_OUT in field.notes:
            say(f"{field.name}: {field.notes[LEFT_OUT]}")
