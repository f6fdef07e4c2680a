"""What the checks see of a machine: its files, and what its tools say."""

from __future__ import annotations

import os
import subprocess
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

TOOL_S = 5.0
"""A tool that takes longer is not waited for [s]."""


def output_of(command: Sequence[str]) -> str | None:
    """What a command prints; None if there is no such command, or it fails."""
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=TOOL_S, check=False)
    except (OSError, subprocess.TimeoutExpired):
        return None
    return done.stdout if done.returncode == 0 else None


def readable_and_writable(path: Path) -> bool:
    """Whether this user may."""
    return os.access(path, os.R_OK | os.W_OK)


@dataclass(frozen=True)
class Machine:
    """A computer, or a folder that looks like one from the root down."""

    root: Path = Path("/")
    run: Callable[[Sequence[str]], str | None] = output_of
    may_use: Callable[[Path], bool] = readable_and_writable

    def at(self, path: str | Path) -> Path:
        """Where a path of that machine is; a relative one begins where we are."""
        return self.root / Path(path).absolute().relative_to("/")

    def text(self, path: str) -> str:
        """What a file says; nothing if it is not there or secret."""
        try:
            return self.at(path).read_text(encoding="utf-8", errors="replace").strip("\0\n ")
        except OSError:
            return ""

    def processes(self) -> Iterator[Path]:
        """The folders of what runs, as in /proc/42, but for our own."""
        for folder in self.at("/proc").glob("[0-9]*"):
            if folder.name != str(os.getpid()):
                yield folder
