"""``brickpose run --robot buildhat`` as a program, on an emulated board with a robot around it."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from websockets.sync.client import ClientConnection, connect
from websockets.sync.connection import Connection

from app.config import ROOT
from benchmarks.hat.emulated_hat import EmulatedHat, emulated_hat

START_S = 90.0
END_S = 15.0
ANSWER_S = 30.0


@dataclass(frozen=True)
class Program:
    """A running program."""

    address: str
    process: subprocess.Popen[str]

    def live(self) -> ClientConnection:
        """A new connection to what it tells and takes."""
        return connect(f"ws://{self.address}/api/live", max_size=None, max_queue=None)

    def threads(self) -> int:
        """How many it has."""
        return len(list(Path(f"/proc/{self.process.pid}/task").iterdir()))

    def descriptors(self) -> int:
        """How many it holds open."""
        return len(list(Path(f"/proc/{self.process.pid}/fd").iterdir()))


@contextmanager
def program(*options: str) -> Iterator[Program]:
    """Start ``brickpose run`` on a free port, and end it as Ctrl-C does.

    Raises:
        RuntimeError: it does not start, or does not end with 0.
    """
    command = [sys.executable, "-m", "app", "run", "--port", "0", *options]
    with subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, text=True) as process:
        try:
            assert process.stdout is not None
            line = process.stdout.readline()
            found = re.search(r"http://(\S+)", line)
            if found is None:
                raise RuntimeError(f"the program did not start: {line!r}")
            yield Program(found[1], process)
        finally:
            process.terminate()
            ended = process.wait(END_S)
    if ended != 0:
        raise RuntimeError(f"the program ended with {ended}")


@contextmanager
def robot_in_bricks(
    folder: Path, seed: int, *options: str
) -> Iterator[tuple[EmulatedHat, Program]]:
    """An emulated board with pybullet's wheels and a rendered camera, and the program on it."""
    eyes = folder / "eyes.sock"
    world = ("--world", "sim", "--pictures", str(eyes), "--seed", str(seed))
    with (
        emulated_hat(folder, *world) as hat,
        program(
            *("--robot", "buildhat", "--serial-port", str(hat.device), "--camera", str(eyes)),
            *("--seed", str(seed), *options),
        ) as running,
    ):
        yield hat, running


def telemetry(socket: Connection) -> dict[str, Any]:
    """The newest message that tells of the robot; answers to commands are passed over."""
    message: dict[str, Any] = {"type": ""}
    while message["type"] != "telemetry":
        message = json.loads(socket.recv(timeout=ANSWER_S))
    return message


def wait_until(socket: Connection, condition: str) -> dict[str, Any]:
    """Telemetry once the robot is "connected", or the filter has an "estimate".

    Raises:
        TimeoutError: it does not come.
    """
    now = first = telemetry(socket)
    while not (now["robot"]["connected"] if condition == "connected" else now["estimate"]):
        if now["stamp"] - first["stamp"] > START_S:
            raise TimeoutError(f"not {condition}: {now['problems']}")
        now = telemetry(socket)
    return now
