"""A student's process on Linux and macOS: a session of its own."""

from __future__ import annotations

import os
import re
import selectors
import signal
import subprocess
import sys
import time
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path

from app.features.course.sandbox.custody import Usage

TOLD = re.compile(r"\s*(\d+)\s+(?:(\d+)-)?((?:\d+:)*\d+(?:\.\d+)?)\s*")
"""What ``ps`` tells: kilobytes; and days, hours, minutes and seconds."""
PS_S = 2.0
"""Time limit for it [s]."""
CHUNK = 1 << 20
"""Most bytes in one part."""


class UnixCustody:
    """A process in a session of its own, which limits itself."""

    def __init__(
        self, command: Sequence[str], folder: Path, environment: Mapping[str, str]
    ) -> None:
        """Start it."""
        self.popen = subprocess.Popen(
            command,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            cwd=folder,
            env=dict(environment),
            start_new_session=True,
        )
        assert self.popen.stdout is not None
        self._said = self.popen.stdout
        self._selector = selectors.DefaultSelector()
        self._selector.register(self._said, selectors.EVENT_READ)

    def receive(self, seconds: float) -> bytes | None:
        """Return what it says next; None if nothing comes in time [s], empty when it has ended."""
        if not self._selector.select(seconds):
            return None
        return os.read(self._said.fileno(), CHUNK)

    def usage(self) -> Usage:
        """Return what it has used so far; where nobody tells, all the time by the clock."""
        pid = self.popen.pid
        if sys.platform == "linux":
            with suppress(OSError):
                stat = Path(f"/proc/{pid}/stat").read_text(encoding="utf-8")
                fields = stat.rpartition(")")[2].split()
                return Usage((int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK"))
        return usage_told_by_ps(pid) or Usage(time.monotonic())

    def kill(self) -> None:
        """End it at once, and all that it started; it may have ended already."""
        with suppress(OSError):
            os.killpg(self.popen.pid, signal.SIGKILL)
        self.popen.kill()

    def close(self) -> None:
        """Close the pipe of a process that has been killed."""
        self._selector.close()
        self._said.close()

    def how_it_ended(self, code: int) -> str | None:
        """Return why a process ended with an exit code, if the system ended it."""
        with suppress(ValueError):  # some signals have no name
            return f"crashed: {signal.Signals(-code).name}" if code < 0 else None
        return None


def usage_told_by_ps(pid: int) -> Usage | None:
    """Return what a process has used, by the program that every Unix has; None if it has ended."""
    command = ["ps", "-o", "rss=,time=", "-p", str(pid)]
    try:
        output = subprocess.run(
            command, capture_output=True, encoding="ascii", timeout=PS_S, check=False
        ).stdout
    except (OSError, subprocess.TimeoutExpired):
        return None
    match = TOLD.fullmatch(output)
    if match is None:
        return None
    seconds = 0.0
    for part in match[3].split(":"):
        seconds = 60 * seconds + float(part)
    return Usage(86400 * int(match[2] or 0) + seconds, int(match[1]) * 1024)
