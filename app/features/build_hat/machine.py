"""The machine that checks look at: its files, processes and tools."""

from __future__ import annotations

import os
import subprocess
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

TOOL_S = 5.0
"""Time limit for a tool [s]."""


def output_of(command: Sequence[str]) -> str | None:
    """Return the output of a command; None if it does not exist, fails or takes too long."""
    try:
        done = subprocess.run(
            command,
            capture_output=True,
            encoding="utf-8",
            errors="replace",
            timeout=TOOL_S,
            check=False,
        )
    except (OSError, subprocess.TimeoutExpired):
        return None
    return done.stdout if done.returncode == 0 else None


def readable_and_writable(path: Path) -> bool:
    """Whether this user may read and write a file."""
    return os.access(path, os.R_OK | os.W_OK)


@dataclass(frozen=True)
class Machine:
    """A computer, or a folder with the same layout as a computer's root folder."""

    root: Path = Path("/")
    run: Callable[[Sequence[str]], str | None] = output_of
    may_use: Callable[[Path], bool] = readable_and_writable

    def at(self, path: str | Path) -> Path:
        """Return a path of the machine under ``root``; a relative path starts in our own folder."""
        whole = Path(path).absolute()
        return self.root / whole.relative_to(whole.anchor)

    def text(self, path: str) -> str:
        """Return the text of a file; empty if it does not exist or may not be read."""
        try:
            return self.at(path).read_text(encoding="utf-8", errors="replace").strip("\0\n ")
        except OSError:
            return ""

    def processes(self) -> Iterator[Path]:
        """Yield the folders of running processes, as /proc/42, except our own."""
        for folder in self.at("/proc").glob("[0-9]*"):
            if folder.name != str(os.getpid()):
                yield folder
