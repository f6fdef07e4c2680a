"""Wakes a coroutine from any thread."""

from __future__ import annotations

import asyncio
import contextlib


class Wakeup:
    """An event of the running event loop that any thread may set."""

    def __init__(self) -> None:
        self._event = asyncio.Event()
        self._loop = asyncio.get_running_loop()

    def set(self) -> None:
        """Wake the coroutine that waits, or the next that will."""
        if not self._event.is_set():
            # The event loop may have ended; then nobody waits any more.
            with contextlib.suppress(RuntimeError):
                self._loop.call_soon_threadsafe(self._event.set)

    async def wait(self) -> None:
        """Wait until it is set; look for what is new afterwards, as more calls count as one."""
        await self._event.wait()
        self._event.clear()
