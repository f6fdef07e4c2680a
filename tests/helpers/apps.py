"""Web applications on a port of their own, in a thread of the test."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager

import uvicorn
from starlette.types import ASGIApp

from app.page.listening import listen

END_S = 20.0


@contextmanager
def listening(app: ASGIApp, **options) -> Iterator[str]:
    """Serve an application until the block ends; yields host:port."""
    socket = listen("127.0.0.1", 0)
    config = uvicorn.Config(
        app, ws="websockets-sansio", log_level="warning", timeout_graceful_shutdown=1, **options
    )
    server = uvicorn.Server(config)
    thread = threading.Thread(target=server.run, kwargs={"sockets": [socket]})
    thread.start()
    try:
        host, port = socket.getsockname()
        yield f"{host}:{port}"
    finally:
        server.should_exit = True
        thread.join(END_S)
        assert not thread.is_alive()
