"""Run ``brickpose`` in processes of their own, and read the telemetry of a running server."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from websockets.sync.client import ClientConnection, connect
from websockets.sync.connection import Connection

from app.settings.config import ROOT

START_S = 90.0
END_S = 15.0
ANSWER_S = 30.0

CHROMIUM = next(
    filter(
        None,
        map(
            shutil.which,
            ("chromium-headless-shell", "chromium", "chromium-browser", "google-chrome"),
        ),
    ),
    None,
)
"""The browser; its build without windows works a fifth less for the same page."""

Telemetry = dict[str, Any]


@dataclass(frozen=True)
class ServedProgram:
    """A running ``brickpose run``."""

    process: subprocess.Popen[str]
    address: str
    """host:port"""

    @property
    def url(self) -> str:
        """Address of the server's page."""
        return f"http://{self.address}"

    def live(self) -> ClientConnection:
        """Open a connection for telemetry and commands; it answers pings even if rarely read."""
        live = f"ws://{self.address}/api/live"
        return connect(live, open_timeout=START_S, max_size=None, max_queue=None)

    def threads(self) -> int:
        """Return the number of its threads."""
        return len(list(Path(f"/proc/{self.process.pid}/task").iterdir()))

    def thread_seconds(self, name: str) -> float:
        """Return the processor time of its threads with a system name [s]."""
        ticks = 0
        for thread in Path(f"/proc/{self.process.pid}/task").iterdir():
            if (thread / "comm").read_text().rstrip("\n") == name:
                fields = (thread / "stat").read_text().rpartition(")")[2].split()
                ticks += int(fields[11]) + int(fields[12])
        return ticks / os.sysconf("SC_CLK_TCK")

    def processor_seconds(self) -> float:
        """Return the processor time of all of its threads, those that ended included [s]."""
        stat = Path(f"/proc/{self.process.pid}/stat").read_text()
        fields = stat.rpartition(")")[2].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")

    def memory_mb(self) -> float:
        """Return the memory that it holds (resident set) [MB]."""
        status = Path(f"/proc/{self.process.pid}/status").read_text()
        (line,) = (line for line in status.splitlines() if line.startswith("VmRSS:"))
        return int(line.split()[1]) / 1024

    def descriptors(self) -> int:
        """Return the number of its open file descriptors."""
        return len(list(Path(f"/proc/{self.process.pid}/fd").iterdir()))


@contextmanager
def started(
    *words: str,
    says: str,
    stderr: int | None = None,
    prefix: Sequence[str] = (),
    begin: type[subprocess.Popen[str]] = subprocess.Popen,
) -> Iterator[tuple[subprocess.Popen[str], str]]:
    """Start ``brickpose`` with these words, and end it as a service is ended.

    ``says`` is a regular expression with a group, ``prefix`` a command that starts commands,
    ``begin`` what starts a process.
    Yields the process, and what the group matches in the first line of its output that matches.

    Raises:
        RuntimeError: the process ends before such a line.
        subprocess.TimeoutExpired: the process does not end; it is killed.
    """
    process = begin(
        [*prefix, sys.executable, "-m", "app", *words],
        cwd=ROOT,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=stderr,
        text=True,
    )
    try:
        yield process, _said(process, says)
    finally:
        process.terminate()
        try:
            process.communicate(timeout=END_S)
        except subprocess.TimeoutExpired:
            process.kill()
            process.communicate()
            raise


def _said(process: subprocess.Popen[str], says: str) -> str:
    assert process.stdout is not None
    said = ""
    while line := process.stdout.readline():
        said += line
        match = re.search(says, line)
        if match is not None:
            return match[1]
    raise RuntimeError(f"the program did not start; it said {said!r}")


def check_ended_well(process: subprocess.Popen[str]) -> None:
    """Check the exit code of a program that has ended.

    Raises:
        RuntimeError: the code is not 0.
    """
    if process.returncode != 0:
        raise RuntimeError(f"the program ended with {process.returncode}")


@contextmanager
def server(
    *options: str,
    stderr: int | None = None,
    prefix: Sequence[str] = (),
    begin: type[subprocess.Popen[str]] = subprocess.Popen,
) -> Iterator[ServedProgram]:
    """Start ``brickpose run`` on a free port; see ``started``."""
    says = r"http://([^\s/]+)"
    words = ("run", "--port", "0", *options)
    with started(*words, says=says, stderr=stderr, prefix=prefix, begin=begin) as begun:
        yield ServedProgram(*begun)


def telemetry(socket: Connection) -> Telemetry:
    """Return the next telemetry message; answers to commands are skipped."""
    message: Telemetry = {"type": ""}
    while message["type"] != "telemetry":
        message = json.loads(socket.recv(timeout=ANSWER_S))
    return message


def until(
    socket: Connection, condition: Callable[[Telemetry], object], seconds: float = 20.0
) -> Telemetry:
    """Wait until a condition holds, and return the telemetry.

    Raises:
        TimeoutError: the condition did not hold for this time of the robot's clock [s].
    """
    message = first = telemetry(socket)
    while not condition(message):
        if message["stamp"] - first["stamp"] >= seconds:
            keys = ("stamp", "truth", "twist", "mode", "filter", "problems")
            raise TimeoutError(f"it never happened; now { {key: message[key] for key in keys} }")
        message = telemetry(socket)
    return message


def connected(message: Telemetry) -> bool:
    """Whether the robot's joints follow commands."""
    return bool(message["robot"]["connected"])


def estimated(message: Telemetry) -> bool:
    """Whether the filter has an estimate."""
    return message["estimate"] is not None
