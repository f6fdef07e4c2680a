"""Keeps a log short, whatever strangers send: lines of one kind are written a few times only."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable
from dataclasses import dataclass

MOST_LINES = 5
"""Lines of one kind that are written in ``PERIOD_S``."""
PERIOD_S = 60.0
MOST_KINDS = 1000

CLIENTS = ("Invalid UTF-8 sequence received from client.",)
"""Mistakes of clients: their tracebacks lead through our server and tell nothing."""


@dataclass
class _Kind:
    since: float
    written: int = 0
    dropped: int = 0


class LogLimit(logging.Filter):
    """Passes a few lines of each kind; the next one tells how many were dropped."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        """Count by a clock [s] that nobody sets: the stamps of lines follow the wall clock."""
        super().__init__()
        self._clock = clock
        self._kinds: dict[tuple[str, str, str], _Kind] = {}

    def filter(self, record: logging.LogRecord) -> bool:
        """Return whether a line is written."""
        if record.msg in CLIENTS:
            record.exc_info = None
        error = record.exc_info[0].__name__ if record.exc_info and record.exc_info[0] else ""
        if len(self._kinds) > MOST_KINDS:
            self._kinds.clear()
        name = (record.name, str(record.msg), error)
        stamp = self._clock()
        kind = self._kinds.setdefault(name, _Kind(stamp))
        if stamp - kind.since > PERIOD_S:
            if kind.dropped:
                record.msg = f"{record.msg} ({kind.dropped} lines more like this were left out)"
            kind = self._kinds[name] = _Kind(stamp)
        kind.written += 1
        if kind.written > MOST_LINES:
            kind.dropped += 1
            return False
        return True


def limit_logs(*names: str) -> None:
    """Limit what loggers of these names write; may be called again."""
    for name in names:
        logger = logging.getLogger(name)
        if not any(isinstance(known, LogLimit) for known in logger.filters):
            logger.addFilter(LogLimit())
