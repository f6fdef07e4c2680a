"""HTTP connections: those that stay silent are closed, and malformed ones are answered."""

from __future__ import annotations

import asyncio
import math
from typing import cast

import h11
from uvicorn.protocols.http.h11_impl import H11Protocol
from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol

from app.page.room import Room

HEAD_S = 10.0
"""A connection without a request under way is closed after this time [s]."""

BAD_REQUEST = b"HTTP/1.1 400 Bad Request\r\nConnection: close\r\nContent-Length: 0\r\n\r\n"


def http_door(place: Room) -> type[HttpDoor]:
    """Return the protocol of a server's connections."""

    class Door(HttpDoor):
        room = place

    return Door


class HttpDoor(H11Protocol):
    """uvicorn's protocol, with a time limit for heads of requests and an answer to all of them."""

    room: Room
    """All connections of the server."""
    _waiting: asyncio.TimerHandle | None = None
    _unread: float = math.inf
    """What it had left of the last answer, when its time was up before [bytes]."""

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Take a connection, and wait for its first request."""
        super().connection_made(transport)
        self._await_head()

    def connection_lost(self, exc: Exception | None) -> None:
        """Forget the connection."""
        self._stop_waiting()
        super().connection_lost(exc)

    def handle_events(self) -> None:
        """Begin with the requests that are complete; no pages while there is too little room."""
        before = self.cycle
        self.limit_concurrency = 0 if self.room.crowded else None
        super().handle_events()
        if self.cycle is not before:
            self._begin_request()

    def handle_websocket_upgrade(self, event: h11.Request) -> None:
        """Hand the connection over to the websockets; refuse a head that they cannot read."""
        self._begin_request()
        if any(n.startswith(b"sec-websocket-") and not v.isascii() for n, v in self.headers):
            self.send_400_response("Headers of websockets are ASCII.")
            return
        super().handle_websocket_upgrade(event)
        upgraded = cast(WebSocketsSansIOProtocol, self.transport.get_protocol())
        if not upgraded.handshake_initiated:
            self.transport.write(BAD_REQUEST)
            self.transport.close()

    def send_400_response(self, msg: str) -> None:
        """Refuse what is no HTTP; if an answer is on its way already, only close."""
        if self.cycle is not None:
            self.cycle.disconnected = True  # what the application still says cannot be sent
            self.cycle.message_event.set()
        if self.conn.our_state in (h11.IDLE, h11.SEND_RESPONSE):
            super().send_400_response(msg)
        else:
            self.transport.close()

    def on_response_complete(self) -> None:
        """Wait for the next request, which may have come already."""
        self._await_head()
        super().on_response_complete()

    def _await_head(self) -> None:
        self._stop_waiting()
        self._waiting = self.loop.call_later(HEAD_S, self._give_up)
        self._unread = math.inf
        self.room.set_silent(self._descriptor(), self.transport.get_write_buffer_size() == 0)

    def _begin_request(self) -> None:
        self._stop_waiting()
        self.room.set_silent(self._descriptor(), False)

    def _stop_waiting(self) -> None:
        if self._waiting is not None:
            self._waiting.cancel()
            self._waiting = None

    def _give_up(self) -> None:
        unread = self.transport.get_write_buffer_size()
        if 0 < unread < self._unread:  # a slow reader is not silent
            self._unread = unread
            self._waiting = self.loop.call_later(HEAD_S, self._give_up)
        else:
            self.transport.abort()

    def _descriptor(self) -> int:
        opened = self.transport.get_extra_info("socket")
        return -1 if opened is None else int(opened.fileno())
