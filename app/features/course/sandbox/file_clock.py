"""The clock of one student's file: it runs from the first question to the last, and never stops."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

FILE_S, COMPILING_FILE_S = 120.0, 600.0
"""Time of all lessons of a file [s]; longer where numba compiles them."""


def compiles(source: str) -> bool:
    """Whether a file uses numba, which compiles a function when it is called first."""
    return "numba" in source


class FileClock:
    """Time by the clock that a file has, whatever it does: computes, sleeps, or talks slowly."""

    def __init__(self, source: str, times: int = 1) -> None:
        """Start it.

        Args:
            source: the file's text.
            times: how often all of it is asked.
        """
        self.seconds = times * (COMPILING_FILE_S if compiles(source) else FILE_S)
        """How long it has [s]."""
        self._end = time.monotonic() + self.seconds

    @property
    def over(self) -> bool:
        """Whether its time is over."""
        return time.monotonic() >= self._end

    @contextmanager
    def ending(self, end: Callable[[], object]) -> Iterator[None]:
        """Call ``end`` from another thread if the time is over before the block is left."""
        timer = threading.Timer(max(self._end - time.monotonic(), 0.0), end)
        timer.name, timer.daemon = "student's clock", True
        timer.start()
        try:
            yield
        finally:
            timer.cancel()
            timer.join()  # it may be ending the process just now
