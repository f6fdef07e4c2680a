"""Passes every value to all subscribers; ``Latest`` passes on only the newest value."""

from __future__ import annotations

import contextlib
import queue
import threading
from collections.abc import Iterator
from typing import Generic, TypeVar

T = TypeVar("T")


class Broadcast(Generic[T]):
    """Values from one thread; each subscriber has its own queue of them."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._feeds: tuple[Feed[T], ...] = ()

    def put(self, value: T) -> None:
        """Pass a value to every subscriber, without waiting for any of them."""
        for feed in self._feeds:
            feed.offer(value)

    @contextlib.contextmanager
    def subscribe(self, most: int) -> Iterator[Feed[T]]:
        """Subscribe until the block ends; at most ``most`` values wait in the queue."""
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
        """Number of values that were lost because the queue was full."""

    def offer(self, value: T) -> None:
        """Put a value in if there is room; else count it as lost."""
        try:
            self._waiting.put_nowait(value)
        except queue.Full:
            self.lost += 1

    def get(self, timeout: float) -> T | None:
        """Return the oldest waiting value; None if none comes within ``timeout`` [s]."""
        try:
            return self._waiting.get(timeout=timeout)
        except queue.Empty:
            return None
