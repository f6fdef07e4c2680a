"""Runs the web application on a socket until it is stopped."""

from __future__ import annotations

import errno
import socket
import sys
from collections.abc import Generator
from contextlib import ExitStack, contextmanager

import uvicorn

from app.engine.engine_thread import EngineThread
from app.engine.program import Program
from app.interruption import deferred
from app.page.access_options import Certificate
from app.page.outlets import Outlets
from app.page.server import create_app
from app.page.tokens import Tokens
from app.page.view.view import SMALL_BUFFER
from robot.errors import PortError

HAND_OVER_S = 0.001
"""Threads hand over Python's lock after this time [s]: a view must not delay the engine's step."""


def listen(host: str, port: int) -> socket.socket:
    """Return a listening socket.

    Raises:
        PortError: the address is not of this machine, or the port is taken or not allowed.
    """
    try:
        result = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM, proto=socket.IPPROTO_TCP)
        family, kind, protocol, _, address = result[0]
        with ExitStack() as unless_it_listens:
            # asyncio sends each part at once only if the protocol is given. Otherwise the second
            # part of an answer waits until the first is acknowledged: 40 ms.
            listening = socket.socket(family, kind, protocol)
            unless_it_listens.callback(listening.close)
            listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            # Data in a large buffer is old when a slow viewer gets it.
            listening.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, SMALL_BUFFER)
            listening.bind(address)
            listening.listen(128)
            unless_it_listens.pop_all()
    except (OSError, UnicodeError) as error:  # UnicodeError: no name of a machine is like this
        why = getattr(error, "strerror", None) or error
        taken = getattr(error, "errno", None) in (errno.EADDRINUSE, errno.EACCES)
        cure = (
            "another port is chosen by --port (or PORT=9000 make run)"
            if taken
            else "valid is an address of this machine, or 0.0.0.0 for all of them"
        )
        raise PortError(f"cannot listen on {host} port {port}: {why}; {cure}") from error
    return listening


class Server:
    """The web application of one program, with the engine's thread."""

    def __init__(
        self,
        program: Program,
        tokens: Tokens | None = None,
        certificate: Certificate | None = None,
    ) -> None:
        """Prepare to serve; requests need one of the tokens, if there are any."""
        self._thread = EngineThread(program.engine, program.loop)
        self._outlets = Outlets(program)
        config = uvicorn.Config(
            create_app(program, self._thread, self._outlets, tokens),
            ssl_certfile=certificate.certfile if certificate else None,
            ssl_keyfile=certificate.keyfile if certificate else None,
            log_level="warning",
            ws="websockets-sansio",
            # Compressing arrays of particles costs ten times the rest, and gains little.
            ws_per_message_deflate=False,
            ws_max_size=2 * 1024 * 1024,
            ws_ping_interval=5,
            ws_ping_timeout=5,
            timeout_graceful_shutdown=1,
        )
        self._uvicorn = _StopsTheRobotFirst(config, self._thread)

    def run(self, sockets: list[socket.socket]) -> None:
        """Serve until stopped."""
        sys.setswitchinterval(HAND_OVER_S)
        self._outlets.start()
        try:
            self._uvicorn.run(sockets=sockets)
        finally:
            self._thread.stopping.set()
            self._outlets.close()

    def stop(self) -> None:
        """Ask the server to end, from any thread or from a signal handler.

        It takes no lock: a second signal would wait forever for a lock that the first one holds.
        """
        self._uvicorn.should_exit = True


def serve(
    program: Program,
    listening: socket.socket,
    tokens: Tokens | None = None,
    certificate: Certificate | None = None,
) -> None:
    """Serve until SIGINT or SIGTERM; then stop the motors first, and disconnect viewers next.

    Raises:
        Interrupted: at the end.
    """
    try:
        server = Server(program, tokens, certificate)
        with deferred(server.stop):
            server.run([listening])
    finally:
        # The engine has closed the robot already, unless it never started.
        program.robot.close()


class _StopsTheRobotFirst(uvicorn.Server):
    def __init__(self, config: uvicorn.Config, thread: EngineThread) -> None:
        super().__init__(config)
        self._thread = thread

    @contextmanager
    def capture_signals(self) -> Generator[None, None, None]:
        """Leave signals to ``serve``; ``shutdown`` follows within a tenth of a second."""
        yield

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        self._thread.stopping.set()
        await super().shutdown(sockets)
