"""Run ``brickpose`` in processes of their own, and read the telemetry of a running server."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
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

    def processes(self) -> list[Path]:
        """Return the folders in ``/proc`` of its process and of those that it started."""
        waiting, all_of_them = [self.process.pid], []
        while waiting:
            folder = Path(f"/proc/{waiting.pop()}")
            with suppress(FileNotFoundError):  # it has ended
                for thread in (folder / "task").iterdir():
                    waiting += map(int, (thread / "children").read_text().split())
                all_of_them.append(folder)
        return all_of_them

    def threads(self) -> int:
        """Return the number of their threads."""
        return sum(len(list((folder / "task").iterdir())) for folder in self.processes())

    def thread_seconds(self, name: str) -> float:
        """Return the processor time of their threads with a system name [s]."""
        ticks = 0
        for folder in self.processes():
            for thread in (folder / "task").iterdir():
                if (thread / "comm").read_text().rstrip("\n") == name:
                    ticks += _ticks(thread / "stat")
        return ticks / os.sysconf("SC_CLK_TCK")

    def processor_seconds(self) -> float:
        """Return the processor time of all of their threads, those that ended included [s]."""
        ticks = sum(_ticks(folder / "stat") for folder in self.processes())
        return ticks / os.sysconf("SC_CLK_TCK")

    def memory_mb(self) -> float:
        """Return the memory that they hold, what they share counted once (PSS) [MB]."""
        kilobytes = 0
        for folder in self.processes():
            lines = (folder / "smaps_rollup").read_text().splitlines()
            (line,) = (line for line in lines if line.startswith("Pss:"))
            kilobytes += int(line.split()[1])
        return kilobytes / 1024

    def descriptors(self) -> int:
        """Return the number of their open file descriptors."""
        return sum(len(list((folder / "fd").iterdir())) for folder in self.processes())


def _ticks(stat: Path) -> int:
    """Return the processor time of a process or thread, in the system's ticks."""
    fields = stat.read_text().rpartition(")")[2].split()
    return int(fields[11]) + int(fields[12])


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
