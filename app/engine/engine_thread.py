"""The thread of the engine, which alone owns the robot."""

from __future__ import annotations

import threading
from collections.abc import Callable

from app.engine.control import ControlLoop
from robot.worker_thread import WorkerThread

JOIN_S = 3.0
"""How long the thread may take to end [s]; a step takes milliseconds."""
HAND_OVER_S = 0.001
"""Threads hand over Python's lock after this time [s]: no other may delay the engine's step."""


class EngineThread(WorkerThread):
    """Runs the engine's loop, which closes the robot at its end."""

    def __init__(
        self, engine: ControlLoop, run: Callable[[threading.Event], None] | None = None
    ) -> None:
        """``run`` replaces the engine's own loop, for example with the loop of a replay."""
        super().__init__("engine", run or engine.run, owner="the engine", patience=JOIN_S)
