"""A mailbox for one value: a newer value replaces it, so nobody waits for a slow reader."""

from __future__ import annotations

import asyncio
import contextlib
import threading
from collections.abc import Iterator
from typing import Generic, TypeVar

T = TypeVar("T")


class Latest(Generic[T]):
    """The newest value from one thread; any thread reads it, and coroutines wait for it."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._value: T | None = None
        self._count = 0
        self._waiting: set[_Waiting] = set()

    def put(self, value: T) -> None:
        """Replace the value, and wake all readers that wait for one."""
        with self._lock:
            self._value = value
            self._count += 1
            waiting = list(self._waiting)
        for item in waiting:
            item.wake()

    def get(self) -> T | None:
        """Return the newest value; None before the first."""
        return self._value

    @contextlib.contextmanager
    def subscribe(self) -> Iterator[Subscription[T]]:
        """Subscribe from a coroutine until the block ends."""
        waiting = _Waiting()
        with self._lock:
            self._waiting.add(waiting)
        try:
            yield Subscription(self, waiting)
        finally:
            with self._lock:
                self._waiting.discard(waiting)

    def newer_than(self, count: int) -> tuple[int, T] | None:
        """Return the newest value and its number, if it came after value number ``count``."""
        with self._lock:
            if self._count == count or self._value is None:
                return None
            return self._count, self._value


class Subscription(Generic[T]):
    """One reader, with the number of the last value that it had."""

    def __init__(self, source: Latest[T], waiting: _Waiting) -> None:
        self._source = source
        self._waiting = waiting
        self._count = 0

    async def next(self) -> T:
        """Wait for a value that this reader has not had; return the newest, skip older ones."""
        while True:
            self._waiting.event.clear()
            result = self._source.newer_than(self._count)
            if result is not None:
                self._count, value = result
                return value
            await self._waiting.event.wait()


class _Waiting:
    def __init__(self) -> None:
        self.event = asyncio.Event()
        self._loop = asyncio.get_running_loop()

    def wake(self) -> None:
        # The event loop may have ended since the look-up; then nobody waits any more.
        with contextlib.suppress(RuntimeError):
            self._loop.call_soon_threadsafe(self.event.set)
