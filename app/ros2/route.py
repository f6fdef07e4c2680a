"""Where messages go: DDS, rosbridge, Foxglove, a recording."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable

from app.ros2.published import Published
from app.ros2.topic import Topic

SLACK = 0.001
"""Ticks come a little early or late; what is nearly due is due [s]."""


class Route(ABC):
    """One way out. An exception ends this route alone, and is shown."""

    name: str
    """In messages to people."""
    patience: float = 0.0
    """How long messages may wait for a route [s]. While all have some, ticks are taken several at a
    time, which costs less."""

    @abstractmethod
    def wants(self, topic: Topic, stamp: float) -> bool:
        """Whether it takes a message of that content; asked at each tick, and yes is a promise.

        Args:
            topic: one of the list.
            stamp: of the content, on the robot's clock [s].
        """

    @abstractmethod
    def take(self, published: Published) -> None:
        """Have a message, in the topics' thread; must not wait for anything."""

    def flush(self) -> None:  # noqa: B027 most have nothing to do
        """Pass on what was taken: there is nothing more in this tick. Must not wait either."""


class Pace:
    """Each topic's new content, and not too often.

    A new pace has had nothing yet, so what never changes is due at once: who comes late is told.
    """

    def __init__(self, period: Callable[[Topic], float]) -> None:
        self._period = period
        self._last: dict[Topic, float] = {}
        self._due: dict[Topic, float] = {}

    def due(self, topic: Topic, stamp: float) -> bool:
        """Whether this content is new and its time has come; if so, it is counted as taken.

        A stamp that jumps back (a replay, a robot that began anew) starts afresh.
        """
        last = self._last.get(topic)
        if stamp == last:
            return False
        due = self._due.get(topic, stamp)
        period = self._period(topic)
        if last is not None and last < stamp < due - SLACK:
            return False
        self._last[topic] = stamp
        # Kept in step with the clock, so that a rate that ticks do not divide is met on average.
        late = last is None or stamp < last or stamp - due > period
        self._due[topic] = (stamp if late else due) + period
        return True
