"""The current problems in plain words, and a record of past ones."""

from __future__ import annotations

import logging
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field

KEPT = 100
"""Problems of the record; older ones are in the log only."""
LOG = logging.getLogger("brickpose")
CLIENTS_LOG = logging.getLogger("brickpose.clients")
"""Mistakes of clients: only a few lines of each kind a minute are logged."""


@contextmanager
def failing_alone(name: str) -> Iterator[None]:
    """Log what the end of a feature, or of a robot, raises: others have to end, too."""
    try:
        yield
    except Exception:
        LOG.exception("%s failed at its end", name)


@dataclass(frozen=True, slots=True)
class Problem:
    """One entry of the record."""

    stamp: float
    """The robot's clock [s]."""
    message: str


@dataclass(frozen=True, slots=True)
class ProblemState:
    """The problems that a tick shows."""

    present: tuple[str, ...]
    """What is wrong now."""
    count: int
    """Problems since the start."""
    record: tuple[Problem, ...] = field(repr=False)
    """The last hundred, newest last."""


class Problems:
    """Problems by topic; a topic has at most one at a time."""

    def __init__(self, level: int = logging.WARNING) -> None:
        """``level`` is the level of the log's entries."""
        self._level = level
        self._now: dict[str, str] = {}
        self.record: tuple[Problem, ...] = ()
        """The last hundred problems, newest last."""
        self.count = 0
        """Problems since the start."""
        self._shown = ProblemState((), 0, ())

    def report(self, topic: str, stamp: float, message: str | None) -> None:
        """Report the problem of a topic, or None without one; log it when it begins."""
        if message is None:
            self._now.pop(topic, None)
        elif self._now.get(topic) != message:
            if topic not in self._now:
                self.note(stamp, message)
            self._now[topic] = message

    def report_all(self, topic: str, stamp: float, messages: Sequence[str]) -> None:
        """Report all problems of a topic; log each when it begins."""
        wrong = {f"{topic}: {message}": message for message in messages}
        for over in [
            item for item in self._now if item.startswith(f"{topic}: ") and item not in wrong
        ]:
            del self._now[over]
        for each, message in wrong.items():
            self.report(each, stamp, message)

    def note(self, stamp: float, message: str) -> None:
        """Add a problem to the record and the log."""
        self.count += 1
        self.record = (*self.record, Problem(stamp, message))[-KEPT:]
        LOG.log(self._level, "%.2f s: %s", stamp, message)

    @property
    def shown(self) -> ProblemState:
        """The problems that a tick shows; the same object as long as they are the same."""
        shown = ProblemState(tuple(self._now.values()), self.count, self.record)
        if shown != self._shown:
            self._shown = shown
        return self._shown
