"""Ends what a class has started: the warm parent with all of its copies, and the hub's services."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path

STUDENT_OF = "BRICKPOSE_STUDENT_OF"
"""In the environment of a student's server: the class's folder."""


def end_copies(place: Path, seconds: float) -> None:
    """End the warm parent that listens at a place, and every process that began as a copy.

    Args:
        place: the parent's socket, which the command lines of parent and copies name.
        seconds: they get so long before they are killed.
    """
    wanted = b"\0".join((b"app.features.classroom.warm.parent", os.fsencode(place)))
    _end(lambda folder: wanted in _command(folder), seconds)
    place.unlink(missing_ok=True)


def end_services(folder: Path, seconds: float) -> None:
    """End the services of a class's hub: where it was killed, they go on with tokens of the past.

    At once: the next hub waits for it, and they keep nothing. The robot that a class shares stops
    by itself when its server ends, however that ends.

    Args:
        folder: the class's, which their environment names.
        seconds: it is waited for so long.
    """
    wanted = b"BRICKPOSE_CLASS=" + os.fsencode(folder) + b"\0"
    _end(lambda process: wanted in (process / "environ").read_bytes(), seconds, (signal.SIGKILL,))


def end_others(folder: Path, seconds: float) -> None:
    """End students' servers that are no copies: JupyterLab's, and those that started cold.

    Args:
        folder: the class's, which their environment names.
        seconds: they get so long before they are killed.
    """
    wanted = STUDENT_OF.encode() + b"=" + os.fsencode(folder) + b"\0"
    _end(lambda process: wanted in (process / "environ").read_bytes(), seconds)


def end_proxy(folder: Path, seconds: float) -> None:
    """End the hub's proxy, if a hub that was killed has left it.

    Args:
        folder: the class's, which has its number.
        seconds: it gets so long before it is killed.
    """
    try:
        pid = (folder / "proxy.pid").read_text().strip()
    except OSError:
        return
    # The number may be another one's by now.
    _end(lambda process: process.name == pid and b"proxy" in _command(process), seconds)


def _command(process: Path) -> bytes:
    return (process / "cmdline").read_bytes()


def _end(
    is_one: Callable[[Path], bool],
    seconds: float,
    signs: Sequence[signal.Signals] = (signal.SIGTERM, signal.SIGKILL),
) -> None:
    for sign in signs:
        end = time.monotonic() + seconds
        for pid in _processes(is_one):
            with suppress(OSError):
                os.kill(pid, sign)
                os.kill(pid, signal.SIGCONT)  # who sleeps hears nothing
        while _processes(is_one) and time.monotonic() < end:
            time.sleep(0.05)


def _processes(is_one: Callable[[Path], bool]) -> list[int]:
    """Return the processes that a function of their folder in ``/proc`` chooses."""
    pids = []
    for folder in Path("/proc").glob("[0-9]*"):
        with suppress(OSError):
            state = (folder / "stat").read_text().rpartition(")")[2].split()[0]
            if state != "Z" and int(folder.name) != os.getpid() and is_one(folder):
                pids.append(int(folder.name))
    return pids
