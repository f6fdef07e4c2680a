"""The program's threads: each has a name, an owner and a bounded end."""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

LOG = logging.getLogger("brickpose")


class WorkerThread:
    """Does one piece of work until it is asked to stop; does not keep the program from ending."""

    def __init__(
        self,
        name: str,
        work: Callable[[threading.Event], None],
        *,
        owner: str,
        patience: float,
        wake: Callable[[], None] | None = None,
        report: Callable[[Exception], None] | None = None,
    ) -> None:
        """Prepare the thread; it runs from ``start`` on.

        Args:
            name: its name in Python and in the system (``top -H``).
            work: what it does; must return soon after its event is set.
            owner: who starts and stops it, for messages.
            patience: how long to wait for its end [s].
            wake: interrupts the work where it waits for something else than the event.
            report: gets an exception that ends the work, in the thread; by default it is logged.
        """
        self.stopping = threading.Event()
        self.failure: Exception | None = None
        """The exception that ended the work; None if none did."""
        self._work = work
        self._owner = owner
        self._patience = patience
        self._wake = wake
        self._report = report
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)

    @property
    def alive(self) -> bool:
        """Whether it runs."""
        return self._thread.is_alive()

    @property
    def ident(self) -> int | None:
        """Python's identifier of the thread; None before the start."""
        return self._thread.ident

    def start(self) -> None:
        """Start the work."""
        self._thread.start()

    def stop(self) -> bool:
        """Ask the work to end and wait for that; may be called twice, and before the start.

        Returns:
            Whether the thread has ended; if it has not, that is logged.
        """
        self.stopping.set()
        if self._wake is not None:
            self._wake()
        return self.join()

    def wait(self, seconds: float) -> bool:
        """Wait for the end, at most for a time [s]; return whether it has ended."""
        self._thread.join(seconds)
        return not self.alive

    def join(self) -> bool:
        """Wait for the end as ``stop`` does, but do not ask for it."""
        if self.alive and self._thread is not threading.current_thread():
            self._thread.join(self._patience)
            if self.alive:
                LOG.error("the thread of %s did not end within %g s", self._owner, self._patience)
        return not self.alive

    def _run(self) -> None:
        with suppress(OSError):  # Linux only
            path = Path(f"/proc/self/task/{threading.get_native_id()}/comm")
            path.write_text(self._thread.name, encoding="utf-8")
        try:
            self._work(self.stopping)
        except Exception as error:
            self.failure = error
            if self._report is None:
                LOG.exception("%s failed", self._owner)
            else:
                self._report(error)
