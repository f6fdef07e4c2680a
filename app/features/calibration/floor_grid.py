"""``/api/floor-grid``: the floor's grid as the camera sees it."""

from __future__ import annotations

from fastapi import APIRouter

from app.engine.program import Program
from app.features.calibration.messages import FloorGridMessage, GridLabelMessage, GridLineMessage
from robot.calibration.mounting.floor_grid import grid_labels, grid_lines


def floor_grid_router(program: Program) -> APIRouter:
    """Tell where the floor's grid lies in the pictures of a program's robot."""
    router = APIRouter()

    @router.get("/api/floor-grid")
    def floor_grid() -> FloorGridMessage:
        """The floor's grid, every 0.1 m, as the camera sees it by the present calibration."""
        view = program.engine.spec.floor_view
        lines = [
            GridLineMessage(
                pixels=[(u, v) for u, v in line.pixels.round(1).tolist()], ahead=line.ahead
            )
            for line in grid_lines(view)
        ]
        labels = [
            GridLabelMessage(distance=round(mark, 3), u=float(u), v=float(v))
            for mark, (u, v) in grid_labels(view)
        ]
        return FloorGridMessage(lines=lines, labels=labels)

    return router
