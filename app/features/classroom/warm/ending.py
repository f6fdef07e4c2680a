"""Ends a warm parent and all of its copies."""

from __future__ import annotations

import os
import signal
import time
from contextlib import suppress
from pathlib import Path


def end_copies(place: Path, seconds: float) -> None:
    """End the warm parent that listens at a place, and every process that began as a copy.

    Args:
        place: the parent's socket, which the command lines of parent and copies name.
        seconds: they get so long before they are killed.
    """
    for sign in (signal.SIGTERM, signal.SIGKILL):
        end = time.monotonic() + seconds
        pids = _processes(place)
        for pid in pids:
            with suppress(OSError):
                os.kill(pid, sign)
                os.kill(pid, signal.SIGCONT)  # who sleeps hears nothing
        while _processes(place) and time.monotonic() < end:
            time.sleep(0.05)
    place.unlink(missing_ok=True)


def _processes(place: Path) -> list[int]:
    """Return the processes whose command line is that of the parent: copies keep it."""
    wanted = b"\0".join((b"app.features.classroom.warm.parent", os.fsencode(place)))
    pids = []
    for folder in Path("/proc").glob("[0-9]*"):
        with suppress(OSError):
            line, state = (folder / "cmdline").read_bytes(), (folder / "stat").read_text()
            if wanted in line and state.rpartition(")")[2].split()[0] != "Z":
                pids.append(int(folder.name))
    return pids
