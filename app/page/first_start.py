"""The first start on a computer: the page shows how far compiling is, before there is a robot."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import partial

from fastapi import FastAPI, HTTPException, WebSocket
from fastapi.responses import JSONResponse

from app.console import say
from app.engine.compiling.compilation import Compilation
from app.engine.compiling.terminal import compile_with_progress
from app.interruption import Interrupted, deferred
from app.languages.marking import phrase
from app.messages.answers import CompilingMessage, HealthMessage
from app.page.access_options import Front
from app.page.application import new_application
from app.page.listening import Listening, listen
from app.page.tokens import Tokens
from app.page.web_server import LeavesSignals, settings_of
from app.settings.config import Config
from robot.worker_thread import WorkerThread

READY = "Compiled; it is ready now"
"""What a program says then, whose address was announced before."""

JOIN_S = 3.0
"""Time to wait for the end of compiling after a signal [s]."""

METHODS = ["GET", "POST", "PUT", "PATCH", "DELETE"]


@contextmanager
def compiled(
    config: Config,
    listening: Listening,
    tokens: Tokens | None,
    front: Front,
    announce: Callable[[], object],
) -> Iterator[tuple[Listening, Callable[[], object]] | None]:
    """Compile what is still to be compiled, and show that on the page meanwhile.

    Yields:
        Where to serve the program, and what to call when it is served: the given socket and
        ``announce``; or, if that socket was used, another one at the same address, which is closed
        at the end of the block. None if a signal asked to end.

    Args:
        config: of the program that comes next.
        listening: the listening socket.
        tokens: requests need one of them, if there are any.
        front: what stands before it.
        announce: prints the address; from then on, a signal is the usual end of the program.
    """
    compilation, port = Compilation(), listening.getsockname()[1]
    if not compilation.needed:
        yield listening, announce
    elif _compiled_on_page(compilation, config, listening, tokens, front, announce):
        with listen(config.host, port) as socket_for_program:
            yield socket_for_program, partial(say, READY)
    else:
        yield None


def _compiled_on_page(
    compilation: Compilation,
    config: Config,
    listening: Listening,
    tokens: Tokens | None,
    front: Front,
    announce: Callable[[], object],
) -> bool:
    """Compile while the page shows it; return whether no signal asked to end."""
    server = LeavesSignals(settings_of(starting_app(config, compilation, tokens), front))

    def stop() -> None:
        server.should_exit = True

    def work(_: object) -> None:
        try:
            compile_with_progress(compilation, lambda: server.should_exit)
        finally:
            stop()

    thread = WorkerThread("compiling", work, owner="the first start", patience=JOIN_S)
    with suppress(Interrupted), deferred(stop) as asked:
        announce()
        thread.start()
        server.serve_on(listening)
        thread.join()
        if not asked():
            if thread.failure is not None:
                raise thread.failure
            return True
    return False


def starting_app(config: Config, compilation: Compilation, tokens: Tokens | None) -> FastAPI:
    """Make the application that is served while there is no robot yet: page and health."""
    app = new_application(config, tokens)
    started = time.monotonic()

    def detail() -> str:
        done, total = compilation.done, compilation.total
        if compilation.complaint:  # then it cannot be kept for later starts
            return phrase(f"Compiling, about a minute: {done} of {total} functions are done.")
        return phrase(f"Compiling, once, about a minute: {done} of {total} functions are done.")

    @app.get("/api/health")
    def health() -> HealthMessage:
        """How far it is."""
        return HealthMessage(
            status="degraded",
            detail=detail(),
            robot=config.robot,
            uptime_s=time.monotonic() - started,
            step_hz=0.0,
            compiling=CompilingMessage(done=compilation.done, total=compilation.total),
        )

    @app.api_route("/{path:path}", methods=METHODS, include_in_schema=False)
    def not_yet(path: str) -> None:
        raise HTTPException(503, detail())

    @app.websocket("/{path:path}")
    async def not_yet_live(socket: WebSocket, path: str) -> None:
        await socket.send_denial_response(JSONResponse({"detail": detail()}, 503))

    return app
