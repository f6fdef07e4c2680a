"""Precedence in processor time for tests with deadlines, ahead of what else the machine does."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

NICENESS = -10

AUTOGROUP = Path("/proc/self/autogroup")
"""Linux shares the processors among sessions; a process's niceness counts within its session."""


@contextmanager
def precedence() -> Iterator[None]:
    """Let this session and what it starts go first, where the user may ask for that."""
    own = os.getpriority(os.PRIO_PROCESS, 0)
    try:
        with suppress(OSError):
            os.setpriority(os.PRIO_PROCESS, 0, NICENESS)
        with suppress(OSError):
            AUTOGROUP.write_text(str(NICENESS))
        yield
    finally:
        with suppress(OSError):
            os.setpriority(os.PRIO_PROCESS, 0, own)
        with suppress(OSError):
            AUTOGROUP.write_text("0")
