"""``/floor.jpg``: the floor before the robot, seen from above."""

from __future__ import annotations

from functools import lru_cache

import cv2
import numpy as np
from fastapi import APIRouter, HTTPException, Response

from app.engine.program import Program
from app.messages.answers import content, refusal
from robot.camera import FloorView
from robot.interface import Frame
from robot.picture_odometry.ground import GroundView

SIDES = (0.12, 0.48, 0.36)
"""Nearest and farthest x, and the width, of the floor that is shown [m]."""
SIZE_M = 0.001
"""Side of a pixel [m]."""
QUALITY = 80


@lru_cache(maxsize=2)
def _ground(view: FloorView) -> GroundView:
    return GroundView.around(view, SIDES, SIZE_M)


def floor_jpeg(view: FloorView, frame: Frame) -> bytes:
    """Return the floor that a picture shows, from above, as JPEG: forward is up, 1 mm a pixel.

    What the picture does not show is black.
    """
    above = _ground(view).project(frame.image)
    fine, data = cv2.imencode(".jpg", above, [cv2.IMWRITE_JPEG_QUALITY, QUALITY])
    if not fine:
        raise ValueError(f"a floor of shape {above.shape} cannot be made a JPEG")
    return np.asarray(data).tobytes()


def floor_router(program: Program) -> APIRouter:
    """Return the route."""
    router = APIRouter()

    @router.get(
        "/floor.jpg",
        response_class=Response,
        responses=content("image/jpeg") | refusal(503, "before the first picture"),
    )
    def floor() -> Response:
        """The floor before the robot from above, 1 mm a pixel: forward is up, 0.12 to 0.48 m."""
        program.engine.audience.visit()
        latest = program.engine.latest.get()
        if latest is None or latest.frame is None:
            raise HTTPException(503, "The camera has sent no picture yet.")
        data = floor_jpeg(latest.spec.floor_view, latest.frame)
        return Response(data, media_type="image/jpeg", headers={"Cache-Control": "no-store"})

    return router
