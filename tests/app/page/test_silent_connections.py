"""Connections without a request under way are closed after a time; those with one are not."""

from __future__ import annotations

import asyncio
import logging
import select
import socket
import threading
import time
from collections.abc import Iterator
from contextlib import suppress

import pytest
import uvicorn
from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import PlainTextResponse, StreamingResponse
from starlette.routing import Route, WebSocketRoute
from starlette.websockets import WebSocket
from websockets.sync.client import connect

from app.page import http_door
from app.page.listening import Listening, listen
from app.page.log_limit import MOST_LINES, PERIOD_S, LogLimit

pytestmark = pytest.mark.slow

SHORT_S = 1.0
LONG_S = 2 * SHORT_S
PATIENCE_S = 20.0
LARGE = 400_000
GET = b"GET / HTTP/1.1\r\nHost: localhost\r\n"


async def page(request: Request) -> PlainTextResponse:
    return PlainTextResponse("hello")


async def stream(request: Request) -> StreamingResponse:
    async def parts():
        yield "begin"
        await asyncio.sleep(LONG_S)
        yield "end"

    return StreamingResponse(parts())


async def echo(socket: WebSocket) -> None:
    await socket.accept()
    await socket.send_text(await socket.receive_text())
    await socket.close()


async def large(request: Request) -> PlainTextResponse:
    return PlainTextResponse("x" * LARGE)


ROUTES = [
    Route("/", page),
    Route("/large", large),
    Route("/stream", stream),
    WebSocketRoute("/echo", echo),
]


@pytest.fixture
def served(monkeypatch) -> Iterator[tuple[uvicorn.Server, tuple[str, int]]]:
    monkeypatch.setattr(http_door, "HEAD_S", SHORT_S)
    listening: Listening = listen("127.0.0.1", 0)
    address = listening.getsockname()
    config = uvicorn.Config(
        Starlette(routes=ROUTES),
        http=http_door.http_door(listening.room),
        ws="websockets-sansio",
        log_level="warning",
        lifespan="off",
        timeout_keep_alive=PATIENCE_S,
    )
    server = uvicorn.Server(config)
    thread = threading.Thread(target=server.run, args=([listening],))
    thread.start()
    yield server, address
    server.should_exit = True
    thread.join(PATIENCE_S)


@pytest.fixture
def address(served) -> tuple[str, int]:
    return served[1]


def rest(raw: socket.socket) -> bytes:
    """All that comes until the other end closes."""
    got = b""
    try:
        while data := raw.recv(65536):
            got += data
    except ConnectionResetError:
        pass
    return got


@pytest.mark.parametrize(
    "begin", [b"", b"GET", GET, GET + b"\r\n"], ids=["none", "a word", "half a head", "answered"]
)
def test_who_says_nothing_more_is_closed(address, begin) -> None:
    with socket.create_connection(address, timeout=PATIENCE_S) as raw:
        raw.sendall(begin)
        assert rest(raw).startswith(b"HTTP/1.1 200") == begin.endswith(b"\r\n\r\n")


@pytest.mark.parametrize("begin", [b"", GET + b"\r\n"], ids=["at first", "after an answer"])
def test_who_says_it_letter_by_letter_is_closed_too(address, begin) -> None:
    with socket.create_connection(address, timeout=PATIENCE_S) as raw:
        raw.sendall(begin + GET + b"X: ")
        raw.settimeout(SHORT_S / 10)
        end = time.monotonic() + PATIENCE_S
        while not ended(raw):
            assert time.monotonic() < end, "it is never closed"
            with suppress(ConnectionError):
                raw.sendall(b"x")


def ended(raw: socket.socket) -> bool:
    """Whether the other end has closed; takes what came."""
    try:
        return not raw.recv(65536)
    except TimeoutError:
        return False
    except ConnectionError:
        return True


def test_an_answer_may_take_longer(address) -> None:
    with socket.create_connection(address, timeout=PATIENCE_S) as raw:
        raw.sendall(GET.replace(b"/ ", b"/stream ") + b"\r\n")
        assert b"end" in rest(raw)


def asks_for_much(address) -> socket.socket:
    raw = socket.socket()
    raw.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
    raw.settimeout(PATIENCE_S)
    raw.connect(address)
    raw.sendall(GET.replace(b"/ ", b"/large ") + b"\r\n")
    return raw


def test_a_slow_reader_gets_all(address) -> None:
    with asks_for_much(address) as raw:
        got, begin = 0, time.monotonic()
        while data := raw.recv(4096):
            got += len(data)
            # As slow as this, it takes longer than the time for a head.
            wait(begin + 2.5 * SHORT_S * got / LARGE)
    assert got > LARGE
    assert time.monotonic() - begin > 2 * SHORT_S


def wait(end: float) -> None:
    """Let a link be slow."""
    time.sleep(max(0.0, end - time.monotonic()))


def test_who_does_not_read_is_closed(served) -> None:
    server, address = served
    with asks_for_much(address) as raw:
        assert select.select([raw], [], [], PATIENCE_S)[0]
        end = time.monotonic() + PATIENCE_S
        while server.server_state.connections:
            assert time.monotonic() < end, "it is never closed"
            wait(time.monotonic() + SHORT_S / 20)
        assert len(rest(raw)) < LARGE


def test_requests_one_after_the_other_go_on(address) -> None:
    with socket.create_connection(address, timeout=PATIENCE_S) as raw:
        end = time.monotonic() + LONG_S
        while time.monotonic() < end:
            raw.sendall(GET + b"\r\n")
            got = b""
            while not got.endswith(b"hello"):
                got += (part := raw.recv(65536))
                assert part, "it is closed"


def test_two_requests_at_once_are_both_answered(address) -> None:
    both = GET.replace(b"/ ", b"/stream ") + b"\r\n" + GET.replace(b"/ ", b"/stream ") + b"\r\n"
    with socket.create_connection(address, timeout=PATIENCE_S) as raw:
        raw.sendall(both)
        assert rest(raw).count(b"end") == 2


def test_a_websocket_may_be_silent(address) -> None:
    host, port = address
    with connect(f"ws://{host}:{port}/echo") as socket:
        with pytest.raises(TimeoutError):
            socket.recv(timeout=LONG_S)
        socket.send("hello")
        assert socket.recv(timeout=PATIENCE_S) == "hello"


def line(text: str) -> logging.LogRecord:
    return logging.LogRecord("x", logging.WARNING, __file__, 1, text, None, None)


def test_a_log_has_a_few_lines_of_each_kind_and_tells_of_the_others() -> None:
    stamps = [0.1 * number for number in range(50)]
    clock = iter([*stamps, 5.0, 2 * PERIOD_S, 2 * PERIOD_S + 1])
    limit = LogLimit(lambda: next(clock))
    written = [limit.filter(line("again")) for _ in stamps]
    assert written == [True] * MOST_LINES + [False] * (50 - MOST_LINES)
    assert limit.filter(line("something else"))
    later = line("again")
    assert limit.filter(later)
    assert later.getMessage() == "again (45 lines more like this were left out)"
    assert limit.filter(line("again"))
