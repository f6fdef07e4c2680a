"""A real server in a process of its own, on a free port of this machine."""

from __future__ import annotations

import contextlib
import json
import re
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from websockets.sync.client import ClientConnection, connect

ROOT = Path(__file__).resolve().parent.parent


@dataclass(frozen=True)
class Server:
    process: subprocess.Popen[str]
    address: str
    """host:port"""

    @property
    def url(self) -> str:
        return f"http://{self.address}"

    def live(self) -> ClientConnection:
        """A client that keeps reading, and so answering pings, while a test looks elsewhere."""
        return connect(f"ws://{self.address}/api/live", max_size=None, max_queue=None)


@contextlib.contextmanager
def serving(*arguments: str) -> Iterator[Server]:
    """Start ``brickpose run``, wait for its address and its first tick; end it afterwards."""
    command = [sys.executable, "-m", "app", "run", "--port", "0", *arguments]
    process = subprocess.Popen(
        command, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    try:
        assert process.stdout is not None
        line = process.stdout.readline()
        found = re.search(r"http://(\S+)", line)
        assert found, f"no address in {line!r}"
        server = Server(process, found[1])
        wait_for_first_tick(server)
        yield server
    finally:
        process.terminate()
        try:
            process.communicate(timeout=15)
        except subprocess.TimeoutExpired:
            process.kill()
            process.communicate()
            raise


def wait_for_first_tick(server: Server) -> None:
    deadline = time.monotonic() + 90
    while time.monotonic() < deadline:
        with contextlib.suppress(OSError), server.live() as socket:
            until(socket, lambda now: now["estimate"] is not None, 90)
            return
    raise TimeoutError("the server did not start")


def telemetry(socket: ClientConnection) -> dict:
    """The next telemetry message."""
    while True:
        message = json.loads(socket.recv(timeout=20))
        if message["type"] == "telemetry":
            return message


def until(socket: ClientConnection, condition, seconds: float = 20.0) -> dict:
    """Telemetry until a condition holds; fails after a time on the robot's clock."""
    first = now = telemetry(socket)
    while not condition(now):
        brief = {name: now[name] for name in ("stamp", "truth", "twist", "mode", "filter")}
        assert now["stamp"] - first["stamp"] < seconds, f"never happened; now {brief}"
        now = telemetry(socket)
    return now


def drive_until(socket: ClientConnection, v: float, condition) -> dict:
    """Telemetry while it drives straight on at v [m/s], until a condition holds."""

    def driving(now: dict) -> bool:
        socket.send(json.dumps({"type": "drive", "v": v, "omega": 0.0}))
        return condition(now)

    return until(socket, driving)


def ask(socket: ClientConnection, **command) -> dict:
    """Send a command and wait for its answer."""
    socket.send(json.dumps(command))
    while True:
        message = json.loads(socket.recv(timeout=20))
        if message["type"] in ("ack", "error"):
            return message
