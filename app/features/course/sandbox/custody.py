"""A student's process as the grader holds it: how much it uses, and its end with all it started."""

from __future__ import annotations

from dataclasses import dataclass
from subprocess import Popen
from typing import Protocol


@dataclass(frozen=True)
class Usage:
    """What a process has used."""

    seconds: float
    """Processor time [s]."""
    memory: int = 0
    """Memory in use [bytes]; 0 where the system holds the limit itself."""


class Custody(Protocol):
    """A started process, with pipes as its standard input and output."""

    popen: Popen[bytes]

    def receive(self, seconds: float) -> bytes | None:
        """Return what it says next; None if nothing comes in time [s], empty when it has ended."""
        ...

    def usage(self) -> Usage:
        """Return what it has used so far."""
        ...

    def kill(self) -> None:
        """End it at once, and all that it started; it may have ended already."""
        ...

    def close(self) -> None:
        """Close the pipe of a process that has been killed."""
        ...

    def how_it_ended(self, code: int) -> str | None:
        """Return why a process ended with an exit code, if the system ended it."""
        ...
