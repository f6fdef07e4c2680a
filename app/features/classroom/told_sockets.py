"""ToldSockets: open sockets of people who may do something else from now on.

A page's socket keeps the right with which it was opened. So it is closed, and the page, which comes
back by itself, has the new one. Whatever it drove stops by that.
"""

from __future__ import annotations

from contextlib import suppress

import anyio
from starlette.types import ASGIApp, Message, Receive, Scope, Send


class ToldSockets:
    """Sockets by whose they are; the event loop's thread alone uses it."""

    def __init__(self) -> None:
        self._open: dict[str, set[anyio.CancelScope]] = {}

    def tell(self, name: str) -> None:
        """Close the sockets of somebody."""
        for scope in tuple(self._open.get(name, ())):
            scope.cancel()

    async def serve(
        self, name: str, app: ASGIApp, scope: Scope, receive: Receive, send: Send
    ) -> None:
        """Serve a socket until it ends, or its owner is told."""
        ended = False

        async def note(message: Message) -> None:
            nonlocal ended
            ended = ended or message["type"] == "websocket.close"
            await send(message)

        own = self._open.setdefault(name, set())
        with anyio.CancelScope() as cancel:
            own.add(cancel)
            try:
                await app(scope, receive, note)
            finally:
                own.discard(cancel)
        if cancel.cancelled_caught and not ended:
            with suppress(Exception):  # the page may have gone meanwhile
                await send({"type": "websocket.close", "code": 1012, "reason": "class"})
