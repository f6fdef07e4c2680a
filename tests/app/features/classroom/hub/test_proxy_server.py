"""The hub's proxy, with a real server behind it and a page before it."""

from __future__ import annotations

import asyncio
import json
import os
import subprocess
import sys
import threading
import time
from contextlib import contextmanager, suppress
from datetime import UTC, datetime
from functools import partial
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import ClassVar
from urllib.request import ProxyHandler, Request, build_opener

import pytest
from classes import needs_hub
from reverse_proxies import free_ports
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect
from websockets.sync.server import serve

from app.features.classroom.wall.followed import FollowedServer

pytestmark = needs_hub
TOKEN = "of-hub-and-proxy"
OPENER = build_opener(ProxyHandler({}))
START_S, STILL_S = 30.0, 0.5
PICTURE = b"x" * (1 << 20)
MANY = 200
"""So many pictures are ten times what sockets of the system have room for."""


@pytest.fixture(scope="module")
def proxy():
    """Ports of a proxy: its own, and that of its interface."""
    port, api_port = free_ports(2)
    words = ["--ip", "127.0.0.1", "--port", str(port)]
    words += ["--api-ip", "127.0.0.1", "--api-port", str(api_port), "--log-level", "error"]
    # The stamps must not depend on where the school is.
    environment = os.environ | {"CONFIGPROXY_AUTH_TOKEN": TOKEN, "TZ": "America/Denver"}
    command = [sys.executable, "-m", "app.features.classroom.hub.proxy_server", *words]
    with subprocess.Popen(command, env=environment) as running:
        end = time.monotonic() + START_S
        while True:
            with suppress(OSError):
                routes(api_port)
                break
            assert running.poll() is None
            assert time.monotonic() < end
            time.sleep(0.02)
        yield port, api_port
        running.terminate()


def routes(api_port: int, path: str = "", body: dict[str, str] | None = None):
    data = None if body is None else json.dumps(body).encode()
    place = f"http://127.0.0.1:{api_port}/api/routes{path}"
    request = Request(place, data, {"Authorization": f"token {TOKEN}"})
    with OPENER.open(request, timeout=START_S) as answer:
        return json.loads(answer.read() or b"null")


@contextmanager
def behind(proxy, handler):
    """A student's server behind the proxy; the address of its socket."""
    port, api_port = proxy
    with serve(handler, "127.0.0.1", 0, compression=None) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        own = server.socket.getsockname()[1]
        routes(api_port, "/user/ada", {"target": f"http://127.0.0.1:{own}"})
        yield f"ws://127.0.0.1:{port}/user/ada/api/live"
        server.shutdown()


def page_of(address: str):
    return connect(address, proxy=None, compression=None, max_size=None, open_timeout=START_S)


def test_words_and_pictures_pass_both_ways(proxy):
    def echo(socket):
        for message in socket:
            socket.send(message)

    with behind(proxy, echo) as address, page_of(address) as page:
        for sent in ("zurück ☂", b"\0\xff", PICTURE):
            page.send(sent)
            assert page.recv(timeout=START_S) == sent


def test_a_page_hears_that_the_server_behind_its_socket_has_ended(proxy):
    def ends(socket):
        socket.send("last")

    with behind(proxy, ends) as address, page_of(address) as page:
        assert page.recv(timeout=START_S) == "last"
        with pytest.raises(ConnectionClosed):
            page.recv(timeout=START_S)


def test_what_a_page_does_not_read_stays_at_the_server(proxy):
    sent: list[float] = []

    def sends(socket):
        with suppress(ConnectionClosed):
            for _ in range(MANY):
                socket.send(PICTURE)
                sent.append(time.monotonic())

    with behind(proxy, sends) as address, page_of(address) as page:
        end = time.monotonic() + START_S
        while not sent or time.monotonic() - sent[-1] < STILL_S:
            assert time.monotonic() < end
            time.sleep(0.02)
        assert len(sent) < MANY / 2
        for _ in range(MANY):
            page.recv(timeout=START_S)
        assert len(sent) == MANY


def test_stamps_of_use_say_their_time_zone(proxy):
    with behind(proxy, lambda socket: socket.recv()):
        stamp = routes(proxy[1])["/user/ada"]["last_activity"]
    used = datetime.fromisoformat(stamp)
    assert used.utcoffset() is not None
    assert abs((datetime.now(UTC) - used).total_seconds()) < START_S


class TakesRecordings(BaseHTTPRequestHandler):
    """A student's server, that takes one recording and refuses others."""

    taken: ClassVar[list[bytes]] = []

    def do_PUT(self) -> None:
        content = self.rfile.read(int(self.headers["Content-Length"]))
        answer = b'{"detail": "there is a recording already"}' if self.taken else b""
        self.taken.append(content)
        self.send_response(409 if answer else 204)
        if answer:
            self.send_header("Content-Length", str(len(answer)))
        self.end_headers()
        self.wfile.write(answer)

    def log_message(self, *_: object) -> None:
        """Say nothing."""


def test_the_wall_hands_out_a_recording_and_hears_why_it_is_not_taken(proxy):
    port, api_port = proxy
    content = b"\x89MCAP%zz&=\xff" * 1000  # no form, whatever a proxy takes it for
    with ThreadingHTTPServer(("127.0.0.1", 0), TakesRecordings) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        target = f"http://127.0.0.1:{server.server_address[1]}"
        routes(api_port, "/user/bo", {"target": target})
        followed = FollowedServer(f"http://127.0.0.1:{port}/user/bo/", "token")
        put = partial(followed.put, "api/recordings/one", content)
        assert asyncio.run(put()) == ""
        assert TakesRecordings.taken == [content]
        assert asyncio.run(put()) == "there is a recording already"
        server.shutdown()
