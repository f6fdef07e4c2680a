"""``/api/tape_seen``: how many of the newest picture's rays meet tape."""

import numpy as np
from fastapi import APIRouter, HTTPException

from app.engine.program import Program


def tape_router(program: Program) -> APIRouter:
    """Return the route."""
    router = APIRouter()

    @router.get("/api/tape_seen")
    def tape_seen() -> dict[str, int]:
        """How many rays there are, and how many of them meet tape."""
        snapshot = program.engine.latest.get()
        if snapshot is None or snapshot.filter.line_scan is None:
            raise HTTPException(503, "there is no picture yet")
        ranges = snapshot.filter.line_scan.scan.ranges
        return {"rays": len(ranges), "tape": int(np.isfinite(ranges).sum())}

    return router
