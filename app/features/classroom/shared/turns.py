"""TurnQueue: whose turn it is to drive a robot that many share, and for how long."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any


@dataclass
class TurnQueue:
    """Names in the order in which they came; one drives for some minutes, if others wait."""

    turn_s: float
    """A turn lasts so long [s]; without anybody who waits it goes on."""
    clock: Callable[[], float] = time.monotonic
    driver: str | None = None
    waiting: list[str] = field(default_factory=list)
    ended: bool = False
    """Nobody drives, and nobody may queue up."""
    _begun: float = 0.0

    def join(self, name: str) -> None:
        """Queue up; who drives or waits already stays in place."""
        if not self.ended and name != self.driver and name not in self.waiting:
            self.waiting.append(name)
        self.look()

    def leave(self, name: str) -> None:
        """Wait no more, or end one's own turn."""
        self.waiting = [each for each in self.waiting if each != name]
        if name == self.driver:
            self.driver = None
        self.look()

    def skip(self) -> None:
        """End the turn of who drives now."""
        self.driver = None
        self.look()

    def hand_to(self, name: str) -> None:
        """Give somebody a turn now; who drove waits at the front."""
        if self.ended or name == self.driver:
            return
        self.waiting = [each for each in self.waiting if each != name]
        if self.driver is not None:
            self.waiting.insert(0, self.driver)
        self._begin(name)

    def end(self, *, ended: bool) -> None:
        """End the queue, or open it anew."""
        self.ended = ended
        if ended:
            self.driver, self.waiting = None, []

    def look(self) -> None:
        """Pass on the turn if it is over and somebody waits."""
        over = self.driver is None or self.seconds_left <= 0
        if over and self.waiting:
            self._begin(self.waiting.pop(0))

    @property
    def seconds_left(self) -> float:
        """Time until the turn is over [s]; without a driver 0."""
        if self.driver is None:
            return 0.0
        return max(self.turn_s - (self.clock() - self._begun), 0.0)

    def to_json(self) -> dict[str, Any]:
        """Return it as JSON values."""
        return {
            "driver": self.driver, "waiting": self.waiting, "ended": self.ended,
            "seconds_left": round(self.seconds_left),
        }  # fmt: skip

    def _begin(self, name: str) -> None:
        self.driver, self._begun = name, self.clock()
