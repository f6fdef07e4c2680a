"""What navigation runs as long as a program, and shows on the page."""

from __future__ import annotations

import base64
from collections.abc import Iterable, Mapping
from typing import Any

from fastapi import APIRouter

from app.engine.program import Program
from app.engine.snapshot import Snapshot
from app.features.navigation.commands import KEEPER
from app.features.navigation.keeper import JourneyKeeper
from app.features.navigation.messages import (
    CostsMessage,
    GoalMessage,
    NavigationPathMessage,
    WallsMessage,
)
from app.features.navigation.walls import walls_in
from app.languages.marking import phrase
from app.messages.telemetry import NavigationMessage
from app.page.outlets import Outlet, Outlets
from app.page.telemetry import pose_message
from robot.navigation.free_space import FreeSpace
from robot.navigation.navigation_status import NavigationStatus
from robot.navigation.settings import TAPE
from robot.navigation.walls import NOTE


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

    @property
    def failures(self) -> Iterable[str]:
        """What the drawing says wrongly."""
        said = self._program.field.notes.get(NOTE, TAPE[0])
        if said not in TAPE:
            yield phrase(f"data-tape-is of the drawing is {said}; valid are wall and ignored")

    def routers(self) -> Iterable[APIRouter]:
        """Return the route that shows the way."""
        return (_router(self._program, self._keeper),)

    def telemetry(self, snapshot: Snapshot) -> Mapping[str, Any]:
        """Return how far the journey is."""
        status: NavigationStatus | None = snapshot.added.get("navigation")
        walls = {"walls": walls_in(snapshot.added).stamp}
        if status is None:
            return walls
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
        return {"navigation": message, **walls}

    def close(self) -> None:
        """Keep no journey up any more."""
        self._keeper.close()


def _router(program: Program, keeper: JourneyKeeper) -> APIRouter:
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

    @router.get("/api/navigation/walls")
    def walls() -> WallsMessage:
        """What the robot does not touch on its way to goals, besides shapes on the floor."""
        return WallsMessage(
            tape="ignored" if keeper.ignores_tape else "wall",
            zones=[[list(corner) for corner in zone] for zone in keeper.walls.zones],
        )

    @router.get("/api/navigation/costs")
    def costs() -> CostsMessage:
        """The inflation layer: what each cell of the floor costs on a way to a goal."""
        return _costs(keeper.space())

    return router


def _costs(space: FreeSpace) -> CostsMessage:
    layer = space.layer()
    settings = space.settings
    return CostsMessage(
        x=space.origin[0],
        y=space.origin[1],
        step=settings.resolution,
        columns=layer.shape[1],
        rows=layer.shape[0],
        inflation_radius=settings.inflation_radius,
        cost_scaling_factor=settings.cost_scaling_factor,
        cells=base64.b64encode(layer.tobytes()).decode("ascii"),
    )
