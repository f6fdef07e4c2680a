"""The subscription of one client to one topic."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from app.ros2.message_types import MessageError
from app.ros2.publisher import Pace
from app.ros2.rosbridge.encoding import COMPRESSIONS
from app.ros2.rosbridge.reading import shown
from app.ros2.topic import Topic
from app.settings.ros2 import Ros2Settings

LONGEST_THROTTLE = 86_400_000
"""Longest throttle: a day [ms]."""

LONGEST_QUEUE = 10_000
"""Most messages that a client may keep waiting."""

MOST_REQUESTS = 100
"""Most requests of one client, with different ids, to follow one topic."""


@dataclass(frozen=True, slots=True)
class SubscribeOptions:
    """The options of one request to follow a topic."""

    throttle: float
    """Least time between two messages [ms]."""
    queue: int
    """How many messages may wait; 0 means only the newest."""
    compression: str
    every: bool
    """Whether to send every message, as for a recording, without the rate limit of live topics."""

    @classmethod
    def of(cls, request: dict[str, Any]) -> SubscribeOptions:
        """Return the options in a ``subscribe`` operation.

        Raises:
            MessageError: an option is invalid; says what is valid.
        """
        compression = request.get("compression") or "none"
        if not isinstance(compression, str) or compression not in COMPRESSIONS:
            valid = ", ".join(COMPRESSIONS)
            raise MessageError(f"compression is {shown(compression)}; valid are {valid}")
        throttle = _within("throttle_rate", request, LONGEST_THROTTLE)
        queue = int(_within("queue_length", request, LONGEST_QUEUE))
        return cls(throttle, queue, compression, request.get("every") is True)


class Subscription:
    """A topic under the name that the client uses; all its requests get the same messages."""

    def __init__(self, name: str, topic: Topic, settings: Ros2Settings) -> None:
        self.name = name
        self.topic = topic
        self.compression = "none"
        self.queue = 0
        self._settings = settings
        self._wishes: dict[Any, SubscribeOptions] = {}
        self._period = 0.0
        self._pace = Pace(lambda topic: self._period)

    def add(self, request_id: Any, wish: SubscribeOptions) -> None:
        """Add a request; content that is already known is due again at once.

        Raises:
            MessageError: there are too many requests.
        """
        if len(self._wishes) >= MOST_REQUESTS and request_id not in self._wishes:
            raise MessageError(f"{self.name} is subscribed {MOST_REQUESTS} times; unsubscribe some")
        self._wishes[request_id] = wish
        self._settle()
        self._pace = Pace(lambda topic: self._period)

    def remove(self, request_id: Any) -> bool:
        """Remove a request, or all of them by None; return whether none is left."""
        if request_id is None:
            self._wishes.clear()
        self._wishes.pop(request_id, None)
        if self._wishes:
            self._settle()
        return not self._wishes

    def due(self, stamp: float) -> bool:
        """Return whether content of this stamp is due; if so, count it as sent."""
        return self._pace.due(self.topic, stamp)

    def _settle(self) -> None:
        """Set the one stream that serves all requests.

        It has the shortest period, the shortest queue and the last compression in the list.
        """
        wishes = self._wishes.values()
        usual = self._settings.period(self.topic.rate)
        self._period = min(
            max(0.0 if wish.every else usual, wish.throttle / 1000) for wish in wishes
        )
        self.queue = min(wish.queue for wish in wishes)
        self.compression = max((wish.compression for wish in wishes), key=list(COMPRESSIONS).index)


def _within(name: str, request: dict[str, Any], most: int) -> float:
    value = request.get(name)
    if value is None:
        return 0
    if type(value) not in (int, float) or not 0 <= value <= most:
        raise MessageError(f"{name} is {shown(value)}; valid is 0 to {most}")
    return float(value)
