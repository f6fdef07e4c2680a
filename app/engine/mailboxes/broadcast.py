"""Every value to all who asked for each of them; ``Latest`` is for those who want the newest."""

from __future__ import annotations

import contextlib
import queue
import threading
from collections.abc import Iterator
from typing import Generic, TypeVar

T = TypeVar("T")


class Broadcast(Generic[T]):
    """Written by one thread; each subscriber has a queue of its own."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._feeds: tuple[Feed[T], ...] = ()

    def put(self, value: T) -> None:
        """Hand a value to every subscriber; waits for none of them."""
        for feed in self._feeds:
            feed.offer(value)

    @contextlib.contextmanager
    def subscribe(self, most: int) -> Iterator[Feed[T]]:
        """Follow for as long as the block lasts; at most so many values wait."""
        feed = Feed[T](most)
        with self._lock:
            self._feeds = (*self._feeds, feed)
        try:
            yield feed
        finally:
            with self._lock:
                self._feeds = tuple(item for item in self._feeds if item is not feed)


class Feed(Generic[T]):
    """One subscriber's queue."""

    def __init__(self, most: int) -> None:
        self._waiting: queue.Queue[T] = queue.Queue(most)
        self.lost = 0
        """Values that came while the queue was full."""

    def offer(self, value: T) -> None:
        """Put a value in if there is room."""
        try:
            self._waiting.put_nowait(value)
        except queue.Full:
            self.lost += 1

    def get(self, timeout: float) -> T | None:
        """The oldest value that waits; None if none comes within the time [s]."""
        try:
            return self._waiting.get(timeout=timeout)
        except queue.Empty:
            return None
