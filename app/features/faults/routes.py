"""Faults that a simulated robot and its camera can have, for sliders on the page."""

from __future__ import annotations

from fastapi import APIRouter

from app.engine.program import Program
from app.features.faults.commands import condition_faults
from app.features.faults.messages import FaultsMessage
from app.messages.answers import ParameterMessage
from app.page.parameters import parameter_message
from app.settings.conditions import CONDITIONS
from app.settings.faults import TABLES, fault_values
from robot.settings import describe


def faults_router(program: Program) -> APIRouter:
    """Return the route that lists the faults."""
    router = APIRouter()

    @router.get("/api/faults")
    def faults() -> FaultsMessage:
        """What can be wrong, and with which value it is; empty for a real robot."""
        if not program.facts.has_faults:
            return FaultsMessage(faults=[], conditions={})
        presets = {name: condition_faults(name) for name in CONDITIONS}
        return FaultsMessage(
            faults=_rows(program),
            # A bump happens once in a run, from its start on: no slider has it.
            conditions={name: preset for name, preset in presets.items() if preset},
        )

    return router


def _rows(program: Program) -> list[ParameterMessage]:
    settings = program.faults
    values, defaults = fault_values(settings), fault_values(program.config.sim)
    return [
        parameter_message(
            "faults", name, describe(getattr(settings, table))[name], values[name], defaults[name]
        )
        for name, table in TABLES.items()
    ]
