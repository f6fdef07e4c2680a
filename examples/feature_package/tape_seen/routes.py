"""``/api/tape_seen``: how many of the newest picture's rays meet tape."""

import numpy as np
from fastapi import APIRouter, HTTPException

from app.engine.program import Program
from app.messages.message import Message


class TapeSeenMessage(Message):
    """How many of the newest picture's rays meet tape."""

    rays: int
    tape: int


MESSAGES = (TapeSeenMessage,)


def tape_router(program: Program) -> APIRouter:
    """Return the route."""
    router = APIRouter()

    @router.get("/api/tape_seen")
    def tape_seen() -> TapeSeenMessage:
        """How many rays there are, and how many of them meet tape."""
        program.engine.audience.visit()  # the camera does not rest while somebody asks
        snapshot = program.engine.latest.get()
        if snapshot is None or snapshot.filter.line_scan is None:
            raise HTTPException(503, "there is no picture yet")
        ranges = snapshot.filter.line_scan.scan.ranges
        return TapeSeenMessage(rays=len(ranges), tape=int(np.isfinite(ranges).sum()))

    return router
