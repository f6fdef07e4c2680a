"""How the program is: telemetry, problems, and whether it works."""

from __future__ import annotations

import math
import time
from typing import Annotated

from fastapi import APIRouter, HTTPException, Query, Response, WebSocket

from app.engine.engine_thread import EngineThread
from app.engine.problems import Problem
from app.engine.program import Program
from app.languages.marking import phrase
from app.messages.answers import HealthMessage, ProblemMessage, ProblemsMessage, refusal
from app.messages.telemetry import TelemetryMessage
from app.page.live import Live
from app.page.outlets import Outlets
from app.page.thresholds import STALE_S
from app.page.view.view import View


def state_router(program: Program, thread: EngineThread, view: View, outlets: Outlets) -> APIRouter:
    """Serve telemetry, what went wrong, and whether the program works.

    Args:
        program: the program.
        thread: its engine's thread.
        view: the 3D view.
        outlets: what carries out commands.
    """
    router = APIRouter()
    engine = program.engine
    live = Live(program, outlets)
    started = time.monotonic()

    @router.get("/api/health", responses={503: {"model": HealthMessage}})
    def health(response: Response) -> HealthMessage:
        """Whether the program works; 503 when it has failed."""
        status, detail = _health(program, thread, view, outlets)
        if status == "failed":
            response.status_code = 503
        latest = engine.latest.get()
        return HealthMessage.model_validate(
            {
                "status": status,
                "detail": detail,
                "robot": program.robot.name,
                "uptime_s": time.monotonic() - started,
                "step_hz": latest.loop.step_hz if latest else 0.0,
            }
        )

    @router.get("/api/state", responses=refusal(503, "before the first tick"))
    def state() -> TelemetryMessage:
        """The newest telemetry."""
        engine.audience.visit()
        latest = engine.latest.get()
        if latest is None:
            raise HTTPException(503, engine.failure or "The robot has not answered yet.")
        return TelemetryMessage.model_validate_json(live.text(latest))

    @router.get("/api/problems")
    def problems() -> ProblemsMessage:
        """What went wrong since the start, and what is wrong with features now."""
        latest = engine.latest.get()
        of_features = (Problem(0.0, words) for words in outlets.failures)
        record = (*of_features, *(latest.problems.record if latest else ()))
        return ProblemsMessage(
            problems=[ProblemMessage(stamp=p.stamp, message=p.message) for p in record],
            trace=latest.filter.trace if latest else "",
        )

    @router.websocket("/api/live")
    async def follow(
        socket: WebSocket, rate: Annotated[float, Query(ge=1, le=1000)] = math.inf
    ) -> None:
        await live.serve(socket, rate)

    return router


def _health(
    program: Program, thread: EngineThread, view: View, outlets: Outlets
) -> tuple[str, str]:
    latest = program.engine.latest.get()
    if program.engine.failure is not None:
        return "failed", program.engine.failure
    if not thread.alive:
        return "failed", phrase("The engine does not run.")
    if latest is None:
        return "degraded", "The robot has not answered yet."
    silent = time.monotonic() - latest.published
    if silent > STALE_S:
        where = program.engine.where_it_hangs(thread.ident)
        return "degraded", " ".join([phrase(f"No tick for {silent:.1f} s."), *where])
    failure = [view.failure] if view.failure else []
    problems = [*latest.problems.present, *failure, *outlets.failures]
    if problems:
        return "degraded", " ".join(problems)
    return "ok", "All is well."
