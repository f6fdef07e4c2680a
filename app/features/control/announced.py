"""AnnouncedAudience, AnnouncedBroadcast, AnnouncedLatest: they tell of who comes, and what is put.

So a thread that passes it on to another process need not look for it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TypeVar

from app.engine.mailboxes.backlog import Backlog
from app.engine.mailboxes.broadcast import Broadcast
from app.engine.mailboxes.latest import Latest
from app.engine.rest import Audience

T = TypeVar("T")


class AnnouncedAudience(Audience):
    """An audience that tells of who comes."""

    def __init__(self, tell: Callable[[], None]) -> None:
        super().__init__()
        self._tell = tell

    def visit(self) -> None:
        """Look for a moment."""
        super().visit()
        self._tell()

    def join(self, rate: float = math.inf) -> None:
        """Count one more."""
        super().join(rate)
        self._tell()


class AnnouncedBroadcast(Broadcast[T]):
    """A broadcast that tells of who subscribes."""

    def __init__(self, tell: Callable[[], None]) -> None:
        super().__init__()
        self._tell = tell

    @contextmanager
    def subscribe(self, most: int) -> Iterator[Backlog[T]]:
        """Subscribe until the block ends."""
        with super().subscribe(most) as backlog:
            self._tell()
            yield backlog


class AnnouncedLatest(Latest[T]):
    """A mailbox that tells of what is put there."""

    def __init__(self, tell: Callable[[], None]) -> None:
        super().__init__()
        self._tell = tell

    def put(self, value: T) -> None:
        """Replace the value."""
        super().put(value)
        self._tell()
