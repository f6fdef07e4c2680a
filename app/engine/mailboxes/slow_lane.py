"""Carries out slow commands of a client one after the other, outside the event loop."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from typing import TypeVar

from anyio import Semaphore, to_thread
from anyio.abc import TaskGroup

T = TypeVar("T")


class SlowLane:
    """Slow commands of one client; used by the event loop."""

    def __init__(self) -> None:
        self._free = Semaphore(1)

    async def begin(
        self, tasks: TaskGroup, work: Callable[[], T], send: Callable[[T], Awaitable[object]]
    ) -> None:
        """Do work in a thread, and send what it returns.

        This waits until the previous work is done. So further messages of the client wait in its
        socket, and never pile up in memory.
        """
        await self._free.acquire()
        tasks.start_soon(self._run, work, send)

    async def _run(self, work: Callable[[], T], send: Callable[[T], Awaitable[object]]) -> None:
        try:
            await send(await to_thread.run_sync(work))
        finally:
            self._free.release()
