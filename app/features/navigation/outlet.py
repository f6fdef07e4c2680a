"""What navigation runs as long as a program, and shows on the page."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from fastapi import APIRouter

from app.engine.program import Program
from app.engine.snapshot import Snapshot
from app.features.navigation.commands import KEEPER
from app.features.navigation.keeper import JourneyKeeper
from app.features.navigation.messages import GoalMessage, NavigationPathMessage
from app.messages.telemetry import NavigationMessage
from app.page.outlets import Outlet, Outlets
from app.page.telemetry import pose_message
from robot.navigation.navigator import NavigationStatus


class NavigationOutlet(Outlet):
    """Journeys of one program."""

    def __init__(self, outlets: Outlets) -> None:
        """Prepare to show them."""
        self._program = outlets.program
        self._keeper = JourneyKeeper(outlets.program)

    @property
    def parts(self) -> Mapping[str, object]:
        """What keeps journeys up."""
        return {KEEPER.name: self._keeper}

    def routers(self) -> Iterable[APIRouter]:
        """Return the route that shows the way."""
        return (_router(self._program),)

    def telemetry(self, snapshot: Snapshot) -> Mapping[str, Any]:
        """Return how far the journey is."""
        status: NavigationStatus | None = snapshot.added.get("navigation")
        if status is None:
            return {}
        message = NavigationMessage(
            state=status.state,
            remaining_m=round(status.remaining_m, 4),
            remaining_s=round(status.remaining_s, 2),
            reason=status.reason or None,
            number=status.number,
            target=pose_message(status.target),
            planned=status.planned,
            on_curve=status.on_curve,
        )
        return {"navigation": message}

    def close(self) -> None:
        """Keep no journey up any more."""
        self._keeper.close()


def _router(program: Program) -> APIRouter:
    router = APIRouter()

    @router.get("/api/navigation")
    def navigation() -> NavigationPathMessage | None:
        """The way of the journey to a goal; null before the first one."""
        latest = program.engine.latest.get()
        status: NavigationStatus | None = latest.added.get("navigation") if latest else None
        if status is None:
            return None
        path = [] if status.path is None else status.path.round(4).tolist()
        return NavigationPathMessage(
            planned=status.planned,
            goals=[GoalMessage(x=x, y=y, theta=theta) for x, y, theta in status.goals],
            path=path,
        )

    return router
