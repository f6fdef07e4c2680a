"""A student's server, as the wall follows it: asked seldom while it sleeps."""

from __future__ import annotations

import asyncio
import socket
import threading
from http.server import BaseHTTPRequestHandler, HTTPServer
from typing import ClassVar

from app.features.classroom.wall.followed import FollowedServer


def test_a_server_that_sleeps_is_asked_again_as_soon_as_its_telemetry_goes_on(monkeypatch):
    server = FollowedServer("http://127.0.0.1:1/user/ada/", "token")
    asked: list[str] = []
    desk = {"asleep": False}

    async def ask(path: str) -> dict[str, bool]:
        asked.append(path)
        return desk.copy()

    monkeypatch.setattr(server, "ask", ask)

    def looks(count: int) -> int:
        asked.clear()
        for _ in range(count):
            asyncio.run(server.look())
        return asked.count("classroom")

    assert looks(3) == 3
    desk["asleep"] = True
    assert looks(5) == 1
    server.telemetry = {"stamp": 1.0}
    desk["asleep"] = False
    assert looks(3) == 3


def test_an_answer_that_is_cut_off_is_none():
    with socket.create_server(("127.0.0.1", 0)) as listening:

        def cut_off() -> None:
            connection, _ = listening.accept()
            with connection:
                connection.recv(4096)
                connection.sendall(b"HTTP/1.1 200 OK\r\nContent-Length: 100\r\n\r\n{")

        serving = threading.Thread(target=cut_off)
        serving.start()
        server = FollowedServer(f"http://127.0.0.1:{listening.getsockname()[1]}/", "token")
        assert asyncio.run(server.ask("classroom")) is None
        serving.join()


class _Elsewhere(BaseHTTPRequestHandler):
    """Another program, as JupyterLab, which has no desk."""

    asked: ClassVar[list[str]] = []

    def do_GET(self) -> None:
        self.asked.append(self.path)
        self.send_error(404)

    def log_message(self, *_: object) -> None:
        """Say nothing."""


def test_another_program_is_asked_once_and_gets_no_orders():
    """Each request would count as a use of a server that nobody uses."""
    _Elsewhere.asked.clear()
    with HTTPServer(("127.0.0.1", 0), _Elsewhere) as listening:
        serving = threading.Thread(target=listening.serve_forever)
        serving.start()
        server = FollowedServer(f"http://127.0.0.1:{listening.server_port}/user/ada/", "token")
        try:
            asyncio.run(asyncio.wait_for(server.follow(), 60))
            for _ in range(3):
                asyncio.run(server.look())
        finally:
            listening.shutdown()
            serving.join()
    assert server.foreign
    assert _Elsewhere.asked == ["/user/ada/classroom"]
