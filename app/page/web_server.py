"""How the web application is served: limits, time-outs and signals."""

from __future__ import annotations

from collections.abc import Generator
from contextlib import contextmanager

import uvicorn
from fastapi import FastAPI

from app.engine.problems import CLIENTS_LOG
from app.page.access_options import Front
from app.page.http_door import http_door
from app.page.listening import BACKLOG, Listening
from app.page.log_limit import limit_logs


def settings_of(app: FastAPI, front: Front) -> uvicorn.Config:
    """Return how to serve an application; with a front, by HTTPS."""
    certificate = front.certificate
    return uvicorn.Config(
        app,
        # By default uvicorn would believe whatever a program on this computer says of its client.
        proxy_headers=bool(front.proxies),
        forwarded_allow_ips=list(front.proxies),
        ssl_certfile=certificate.certfile if certificate else None,
        ssl_keyfile=certificate.keyfile if certificate else None,
        log_level="warning",
        # Others do not ask our socket whom to accept: Windows' usual loop, uvloop.
        loop="asyncio:SelectorEventLoop",
        backlog=BACKLOG,
        ws="websockets-sansio",
        # Compressing arrays of particles costs ten times as much as the rest, and saves little.
        ws_per_message_deflate=False,
        ws_max_size=2 * 1024 * 1024,
        # A page whose own thread is busy answers no ping: none gets through behind pictures.
        ws_ping_interval=5,
        ws_ping_timeout=30,
        timeout_graceful_shutdown=1,
    )


class LeavesSignals(uvicorn.Server):
    """A server that leaves signals to whoever runs it, who then sets ``should_exit``."""

    def serve_on(self, listening: Listening) -> None:
        """Serve on a socket until ``should_exit`` is set; then the socket is closed."""
        limit_logs("uvicorn.error", "asyncio", CLIENTS_LOG.name)
        self.config.http = http_door(listening.room)
        self.run(sockets=[listening])

    @contextmanager
    def capture_signals(self) -> Generator[None, None, None]:
        """Take none; after ``should_exit``, ``shutdown`` follows within a tenth of a second."""
        yield
