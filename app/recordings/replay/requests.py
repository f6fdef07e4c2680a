"""What people ask of a replay: from any thread, in any order, and the newest wins."""

from __future__ import annotations

import threading
from dataclasses import dataclass

SLOWEST, FASTEST = 0.05, 50.0
"""Seconds of the recording in one second."""


@dataclass(slots=True)
class Requests:
    """Since the last look; None is no wish."""

    paused: bool | None = None
    speed: float | None = None
    position_s: float | None = None
    steps: int = 0
    """Pictures to go on, or back."""


class RequestMailbox:
    """The mailbox."""

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
        """Ask for something; a new position outdates steps that were not yet taken."""
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
        """All that was asked since the last time."""
        with self._changed:
            requests, self._wishes, self._some = self._wishes, Requests(), False
        return requests

    def wait(self, seconds: float) -> bool:
        """Until something is asked, but not longer; whether something was."""
        with self._changed:
            return self._changed.wait_for(lambda: self._some, max(seconds, 0.0))
