"""The thread that the engine runs in; it alone owns the robot."""

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
        """``run`` takes the place of the engine's own loop, as that of a replay."""
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
        """By which Python knows it; None before the start."""
        return self._thread.ident

    def start(self) -> None:
        """Begin."""
        self._thread.start()

    def stop(self) -> None:
        """End; the robot is stopped and closed on the way."""
        self.stopping.set()
        self._thread.join(JOIN_S)
        if self._thread.is_alive():
            LOG.error("the engine's thread did not end within %g s", JOIN_S)
