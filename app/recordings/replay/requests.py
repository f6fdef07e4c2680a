"""Requests to a replay, from any thread, in any order; the newest one wins."""

from __future__ import annotations

import threading
from dataclasses import dataclass

SLOWEST, FASTEST = 0.05, 50.0
"""Limits of the speed: seconds of the recording in one second."""


@dataclass(slots=True)
class Requests:
    """The requests since they were last taken; None means no request."""

    paused: bool | None = None
    speed: float | None = None
    position_s: float | None = None
    steps: int = 0
    """Pictures to step forward; negative to step back."""


class RequestMailbox:
    """Collects requests until the replay takes them."""

    def __init__(self) -> None:
        self._wishes = Requests()
        self._changed = threading.Condition()
        self._some = False

    def ask(
        self,
        paused: bool | None = None,
        speed: float | None = None,
        position_s: float | None = None,
        step: int | None = None,
    ) -> None:
        """Add requests; a new position cancels steps that were not taken yet."""
        with self._changed:
            requests = self._wishes
            requests.paused = requests.paused if paused is None else paused
            if speed is not None:
                requests.speed = min(max(speed, SLOWEST), FASTEST)
            if position_s is not None:
                requests.position_s, requests.steps = position_s, 0
            if step is not None:
                requests.steps += step
            self._some = True
            self._changed.notify_all()

    def take(self) -> Requests:
        """Take all requests since the last call."""
        with self._changed:
            requests, self._wishes, self._some = self._wishes, Requests(), False
        return requests

    def wait(self, seconds: float) -> bool:
        """Wait for a request, at most some seconds; return whether there is one."""
        with self._changed:
            return self._changed.wait_for(lambda: self._some, max(seconds, 0.0))
