"""What lists runs as long as a program, and hands them on to the next one."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from fastapi import APIRouter

from app.engine.snapshot import Snapshot
from app.features.run_table.routes import runs_router
from app.features.run_table.run_log import RunLog
from app.page.outlets import Outlet, Outlets


class RunsOutlet(Outlet):
    """The runs of one program, as far as somebody looks at it: they are what pages are told."""

    def __init__(self, outlets: Outlets) -> None:
        """Go on with the runs of the program before."""
        program = outlets.program
        earlier = program.handed_on.get("run_table")
        self._log = RunLog(program.field.name, earlier if isinstance(earlier, RunLog) else None)

    @property
    def handed_on(self) -> RunLog:
        """The runs so far."""
        return self._log

    def routers(self) -> Iterable[APIRouter]:
        """Return the routes that list them."""
        return (runs_router(self._log),)

    def telemetry(self, snapshot: Snapshot) -> Mapping[str, Any]:
        """Take what a tick tells of the run; telemetry says nothing of it."""
        self._log.add(snapshot)
        return {}
