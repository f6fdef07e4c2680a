"""A real server in a process of its own, on a free port of this machine."""

from __future__ import annotations

import json
import math
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from urllib.request import urlopen

from warm_start import WarmProgram
from websockets.sync.client import ClientConnection

from app.settings.config import ROOT
from benchmarks import programs
from benchmarks.programs import ANSWER_S, START_S, ServedProgram, estimated, telemetry, until

__all__ = [
    "ROOT",
    "ServedProgram",
    "ask",
    "drive_until",
    "pose_error",
    "server",
    "serving",
    "stamp_now",
    "started",
    "telemetry",
    "until",
]


started = partial(programs.started, begin=WarmProgram)
server = partial(programs.server, begin=WarmProgram)


@contextmanager
def serving(*arguments: str) -> Iterator[ServedProgram]:
    """Start ``brickpose run``, wait for its address and its first tick; end it afterwards."""
    with server(*arguments, stderr=subprocess.PIPE) as running:
        with running.live() as socket:
            until(socket, estimated, START_S)
        yield running


def stamp_now(server: ServedProgram) -> float:
    """The robot's clock now [s]; a live connection may still hold what was told before."""
    with urlopen(f"{server.url}/api/state", timeout=ANSWER_S) as answer:
        return float(json.load(answer)["stamp"])


def pose_error(now: dict) -> float:
    """Distance of the estimate from the truth [m]; inf while there is no estimate."""
    estimate, truth = now["estimate"], now["truth"]
    if estimate is None:
        return math.inf
    return math.dist((estimate["x"], estimate["y"]), (truth["x"], truth["y"]))


def drive_until(socket: ClientConnection, v: float, condition) -> dict:
    """Telemetry while it drives straight on at v [m/s], until a condition holds."""

    def driving(now: dict) -> bool:
        socket.send(json.dumps({"type": "drive", "v": v, "omega": 0.0}))
        return condition(now)

    return until(socket, driving)


def ask(socket: ClientConnection, **command) -> dict:
    """Send a command and wait for its answer."""
    socket.send(json.dumps(command))
    return answer(socket)


def answer(socket: ClientConnection) -> dict:
    """Wait for the answer to a command."""
    while True:
        message = json.loads(socket.recv(timeout=ANSWER_S))
        if message["type"] in ("ack", "error"):
            return message
