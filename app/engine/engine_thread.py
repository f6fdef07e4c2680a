"""The thread of the engine, which alone owns the robot."""

from __future__ import annotations

import threading
from collections.abc import Callable

from app.engine.engine import Engine
from app.engine.problems import LOG

JOIN_S = 3.0


class EngineThread:
    """Starts and ends the engine's loop."""

    def __init__(
        self, engine: Engine, run: Callable[[threading.Event], None] | None = None
    ) -> None:
        """``run`` replaces the engine's own loop, for example with the loop of a replay."""
        self.stopping = threading.Event()
        self._thread = threading.Thread(
            target=run or engine.run, args=(self.stopping,), name="engine", daemon=True
        )

    @property
    def alive(self) -> bool:
        """Whether the loop runs."""
        return self._thread.is_alive()

    @property
    def ident(self) -> int | None:
        """Python's identifier of the thread; None before the start."""
        return self._thread.ident

    def start(self) -> None:
        """Start the loop."""
        self._thread.start()

    def stop(self) -> None:
        """End the loop, which stops and closes the robot."""
        self.stopping.set()
        self._thread.join(JOIN_S)
        if self._thread.is_alive():
            LOG.error("the engine's thread did not end within %g s", JOIN_S)
