"""Destinations of messages: DDS, rosbridge, Foxglove, a recording."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable

from app.ros2.topic import Published, Topic

SLACK = 0.001
"""Tolerance for content that is nearly due, as ticks come a little early or late [s]."""


class Route(ABC):
    """One destination of messages. An exception ends only this route, and is shown."""

    name: str
    """The route's name in messages to people."""
    patience: float = 0.0
    """How long messages may wait for this route [s]. While all routes have patience, several ticks
    are taken at a time, which costs less."""

    @abstractmethod
    def wants(self, topic: Topic, stamp: float) -> bool:
        """Whether the route takes a message of this content; asked at each tick.

        After True, the route has to take the message.

        Args:
            topic: one of ``TOPICS``.
            stamp: stamp of the content, on the robot's clock [s].
        """

    @abstractmethod
    def take(self, published: Published) -> None:
        """Take a message, in the topics' thread; must not wait for anything."""

    def flush(self) -> None:  # noqa: B027 most have nothing to do
        """Pass the taken messages on; called at the end of a tick. Must not wait either."""


class Pace:
    """Selects the new content of each topic, at a limited rate.

    A new pace has no history, so content that never changes is due at once. That way, late
    subscribers get it.
    """

    def __init__(self, period: Callable[[Topic], float]) -> None:
        self._period = period
        self._last: dict[Topic, float] = {}
        self._due: dict[Topic, float] = {}

    def due(self, topic: Topic, stamp: float) -> bool:
        """Return whether this content is new and due; if so, count it as taken.

        If the stamp jumps back (a replay, a restarted robot), the content is due.
        """
        last = self._last.get(topic)
        if stamp == last:
            return False
        due = self._due.get(topic, stamp)
        period = self._period(topic)
        if last is not None and last < stamp < due - SLACK:
            return False
        self._last[topic] = stamp
        # Count from the last due time, not from the stamp, so that the mean rate is right even if
        # the period is no multiple of the tick.
        late = last is None or stamp < last or stamp - due > period
        self._due[topic] = (stamp if late else due) + period
        return True
