"""A mailbox for one value: a newer value replaces it, so nobody waits for a slow reader."""

from __future__ import annotations

import contextlib
import math
import threading
import time
from collections.abc import Iterator
from typing import Generic, TypeVar

import anyio

from app.engine.mailboxes.rhythm import EARLY_S, Rhythm
from app.engine.mailboxes.wakeup import Wakeup

T = TypeVar("T")


class Latest(Generic[T]):
    """The newest value from one thread; any thread reads it, and coroutines wait for it."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._value: T | None = None
        self._count = 0
        self._waiting: set[Wakeup] = set()

    def put(self, value: T) -> None:
        """Replace the value, and wake all readers that wait for one."""
        with self._lock:
            self._value = value
            self._count += 1
            waiting = list(self._waiting)
        for item in waiting:
            item.set()

    def get(self) -> T | None:
        """Return the newest value; None before the first."""
        return self._value

    @contextlib.contextmanager
    def subscribe(self, rate: float = math.inf) -> Iterator[LatestReader[T]]:
        """Subscribe from a coroutine until the block ends, to so many values a second at most."""
        waiting = Wakeup()
        with self._lock:
            self._waiting.add(waiting)
        try:
            yield LatestReader(self, waiting, rate)
        finally:
            with self._lock:
                self._waiting.discard(waiting)

    def newer_than(self, count: int) -> tuple[int, T] | None:
        """Return the newest value and its number, if it came after value number ``count``."""
        with self._lock:
            if self._count == count or self._value is None:
                return None
            return self._count, self._value


class LatestReader(Generic[T]):
    """One reader, with the number of the last value that it had."""

    def __init__(self, source: Latest[T], waiting: Wakeup, rate: float) -> None:
        self._source = source
        self._waiting = waiting
        self._rate = rate
        self._rhythm = Rhythm()
        self._count = 0

    async def next(self) -> T:
        """Wait for a value that this reader has not had; return the newest, skip older ones."""
        while True:
            result = self._source.newer_than(self._count)
            if result is None:
                await self._waiting.wait()
                continue
            clock = time.monotonic()
            wait = self._rhythm.wait(clock)
            if wait <= 0:
                self._rhythm.choose(clock, self._rate)
                self._count, value = result
                return value
            # A newer one may come first; but the last of all must be sent, too.
            with anyio.move_on_after(wait + EARLY_S):
                await self._waiting.wait()
