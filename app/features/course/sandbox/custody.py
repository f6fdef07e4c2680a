"""The usage of a student's process, as its custody tells it."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Usage:
    """What a process has used."""

    seconds: float
    """Processor time [s]."""
    memory: int = 0
    """Memory in use [bytes]; 0 where the system holds the limit itself."""
