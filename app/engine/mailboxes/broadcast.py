"""Passes every value to all subscribers; ``Latest`` passes on only the newest value."""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Iterator
from typing import Generic, TypeVar

from app.engine.mailboxes.backlog import Backlog

T = TypeVar("T")


class Broadcast(Generic[T]):
    """Values from one thread; each subscriber has its own backlog of them."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._backlogs: tuple[Backlog[T], ...] = ()

    @property
    def subscribed(self) -> bool:
        """Whether there is any subscriber."""
        return bool(self._backlogs)

    def put(self, value: T) -> None:
        """Pass a value to every subscriber, without waiting for any of them."""
        for backlog in self._backlogs:
            backlog.put(value)

    @contextlib.contextmanager
    def subscribe(self, most: int) -> Iterator[Backlog[T]]:
        """Subscribe until the block ends; at most ``most`` values wait in the backlog."""
        backlog = Backlog[T](most)
        with self._lock:
            self._backlogs = (*self._backlogs, backlog)
        try:
            yield backlog
        finally:
            with self._lock:
                self._backlogs = tuple(item for item in self._backlogs if item is not backlog)
