"""What is no HTTP, or no websocket, gets an answer or a closed door, and leaves no traceback."""

from __future__ import annotations

import base64
import random
import socket
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import httpx
import pytest
from serving import ServedProgram, server, until

from benchmarks.programs import estimated

pytestmark = pytest.mark.slow

GET = b"GET / HTTP/1.1\r\nHost: localhost\r\n"
POST = b"POST / HTTP/1.1\r\nHost: localhost\r\n"
KEY = b"Sec-WebSocket-Key: " + base64.b64encode(bytes(16)) + b"\r\n"
UPGRADE = b"Connection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n"
LIVE = b"GET /api/live HTTP/1.1\r\nHost: localhost\r\n" + UPGRADE

REFUSED = {
    "garbage": b"\x00\x01\x02garbage\r\n\r\n",
    "TLS": b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03" + bytes(64) + b"\r\n\r\n",
    "no host": b"GET / HTTP/1.1\r\n\r\n",
    "two hosts": GET + b"Host: evil.example\r\n\r\n",
    "a long head": GET + b"X: " + b"x" * 100_000,
    "a header without a name": GET + b": x\r\n\r\n",
    "a null in a header": GET + b"X: \x00\r\n\r\n",
    "a space in the target": b"GET /a b HTTP/1.1\r\nHost: localhost\r\n\r\n",
    "a length that is none": POST + b"Content-Length: -1\r\n\r\n",
    "two lengths": POST + b"Content-Length: 1\r\nContent-Length: 2\r\n\r\n",
    "an encoding that is none": POST + b"Transfer-Encoding: zip\r\n\r\n",
    "POST to a websocket": LIVE.replace(b"GET", b"POST") + KEY + b"\r\n",
    "an upgrade without a key": LIVE + b"\r\n",
    "an upgrade with a short key": LIVE + b"Sec-WebSocket-Key: abc\r\n\r\n",
    "an upgrade in another alphabet": LIVE + KEY.replace(b"A", b"\xc4") + b"\r\n",
    "an upgrade with many headers": LIVE + KEY + b"X: x\r\n" * 400 + b"\r\n",
    "an upgrade with a long header": LIVE + KEY + b"X: " + b"x" * 12_000 + b"\r\n\r\n",
}
"""What is answered by 400."""

CHUNKED = b"Transfer-Encoding: chunked\r\n\r\n"
CLOSED = {
    "a chunk that is none": POST + CHUNKED + b"zz\r\n",
    "a chunk that is too long": POST + CHUNKED + b"f" * 40 + b"\r\n",
    "a chunk without an end": POST + CHUNKED + b"1\r\nabc\r\n",
    "a chunk of a GET": GET + CHUNKED + b"zz\r\n",
    "a chunk at the camera": GET.replace(b"/ ", b"/camera.mjpg ") + CHUNKED + b"zz\r\n",
    "an old version": LIVE.replace(b": 13", b": 7") + KEY + b"\r\n",
}
"""What is answered by whatever fits what came before, and closed."""

FRAMES = {
    "garbage": b"\xff" * 40,
    "a text that is none": b"\x81\x84\x00\x00\x00\x00\xff\xfe\xff\xfe",
    "a frame without a mask": b"\x81\x02{}",
    "a frame that is too long": b"\x81\xff" + b"\x7f" * 12,
    "a close with half a code": b"\x88\x81\x00\x00\x00\x00\x01",
    "a rest without a beginning": b"\x80\x81\x00\x00\x00\x00x",
}
"""What ends a websocket."""


@pytest.fixture(scope="module")
def served(tmp_path_factory) -> Iterator[tuple[ServedProgram, Path]]:
    """A program and its log."""
    log = tmp_path_factory.mktemp("log") / "log.txt"
    options = ("--robot", "kinematic", "--map", "stub")
    with log.open("w") as out, server(*options, stderr=out.fileno()) as running:
        with running.live() as live:
            until(live, estimated, 90)
        yield running, log


def answer(server: ServedProgram, *parts: bytes) -> bytes:
    """All that comes back until the server closes."""
    host, port = server.address.split(":")
    with socket.create_connection((host, int(port)), timeout=20) as raw:
        got = b""
        try:
            for part in parts:
                raw.sendall(part)
            while data := raw.recv(65536):
                got += data
        except (ConnectionResetError, BrokenPipeError):
            pass  # the rest of a long request was not read
        return got


@pytest.fixture(autouse=True)
def no_traceback(served) -> Iterator[None]:
    yield
    running, log = served
    assert "Traceback" not in log.read_text()
    assert httpx.get(f"{running.url}/api/health", timeout=20).json()["status"] == "ok"


def drain(raw: socket.socket) -> None:
    """Read until the other side closes."""
    with suppress(ConnectionError):
        while raw.recv(65536):
            pass


@pytest.mark.parametrize("request_", REFUSED.values(), ids=REFUSED.keys())
def test_what_cannot_be_read_is_refused(served, request_) -> None:
    assert answer(served[0], request_).startswith(b"HTTP/1.1 400 ")


@pytest.mark.parametrize("request_", CLOSED.values(), ids=CLOSED.keys())
def test_what_goes_wrong_later_is_closed(served, request_) -> None:
    assert answer(served[0], request_).startswith(b"HTTP/1.1 ")


@pytest.mark.parametrize("frames", FRAMES.values(), ids=FRAMES.keys())
@pytest.mark.parametrize("path", ["/api/live", "/rosbridge", "/view", "/api/camera"])
def test_frames_that_are_none_end_the_websocket(served, path, frames) -> None:
    host, port = served[0].address.split(":")
    with socket.create_connection((host, int(port)), timeout=20) as raw:
        raw.sendall(LIVE.replace(b"/api/live", path.encode()) + KEY + b"\r\n")
        assert raw.recv(12) == b"HTTP/1.1 101"
        raw.sendall(frames)
        drain(raw)


def test_a_bad_chunk_after_the_answer_is_closed_too(served) -> None:
    running, _ = served
    host, port = running.address.split(":")
    with socket.create_connection((host, int(port)), timeout=20) as raw:
        raw.sendall(POST + CHUNKED)
        assert raw.recv(65536).startswith(b"HTTP/1.1 405 ")
        with suppress(ConnectionError):
            for _ in range(3):
                raw.sendall(b"zz\r\n")
        drain(raw)


def test_requests_with_wrong_bytes_leave_no_traceback(served) -> None:
    rng = random.Random(0)
    models = [*REFUSED.values(), *CLOSED.values(), GET + b"\r\n", LIVE + KEY + b"\r\n"]
    for _ in range(400):
        request = bytearray(rng.choice(models)[:2000])
        for _ in range(rng.randint(1, 6)):
            request[rng.randrange(len(request))] = rng.randrange(256)
        running, _ = served
        host, port = running.address.split(":")
        with socket.create_connection((host, int(port)), timeout=20) as raw:
            raw.sendall(bytes(request))
            raw.shutdown(socket.SHUT_WR)
            raw.settimeout(0.05)
            with suppress(TimeoutError):
                drain(raw)


def test_the_log_stays_short(served) -> None:
    running, log = served
    before = len(log.read_text().splitlines())
    for _ in range(200):
        answer(running, REFUSED["garbage"])
    assert len(log.read_text().splitlines()) - before < 20
