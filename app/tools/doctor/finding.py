"""What a check looks at, the machine, and what it finds."""

from __future__ import annotations

import os
import subprocess
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

OK, WARNING, PROBLEM = "ok", "warning", "problem"
TOOL_S = 5.0
"""Time limit for a tool [s]."""


@dataclass(frozen=True, slots=True)
class Finding:
    """One line of the report."""

    level: str
    """``ok``; ``warning``: it works, but could be better; ``problem``: it does not work."""
    message: str
    """What the check found."""
    cure: str = ""
    """What to do, if ``message`` does not already say it."""

    def __str__(self) -> str:
        line = f"{self.level:<8} {self.message}"
        return f"{line}. Cure: {self.cure}" if self.cure else line


def ok(message: str) -> Finding:
    """Return a finding that all is well."""
    return Finding(OK, message)


def warning(message: str, cure: str = "") -> Finding:
    """Return a finding that something works but should be better."""
    return Finding(WARNING, message, cure)


def problem(message: str, cure: str = "") -> Finding:
    """Return a finding that something does not work."""
    return Finding(PROBLEM, message, cure)


def sentence(text: str) -> str:
    """Return a text with its first letter in upper case."""
    return text[:1].upper() + text[1:]


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
