"""Requests of a client, parsed from JSON, possibly in fragments; and its subscriptions."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Any

from app.features.ros.message_types import MessageError
from app.features.ros.publisher import Pace, sent_every
from app.features.ros.rosbridge.encoding import COMPRESSIONS
from app.features.ros.rosbridge.reading import shown
from app.features.ros.topics import Topic
from app.settings.groups import Ros2Settings

LONGEST = 200_000
"""Longest message [characters]; messages to a robot are shorter."""

LONGEST_NAME = 200
"""Longest topic, type and id [characters]; answers repeat them."""

MOST_PIECES = 1000
MOST_OPEN = 10
"""Most messages that a client may send in fragments at the same time."""

Request = dict[str, Any]
LONGEST_THROTTLE = 86_400_000
"""Longest throttle: a day [ms]."""
LONGEST_QUEUE = 10_000
"""Most messages that a client may keep waiting."""
MOST_REQUESTS = 100
"""Most requests of one client, with different ids, to follow one topic."""


def parse(data: str | bytes) -> Request:
    """Return the operation in a message.

    Raises:
        MessageError: the message is not an operation; says what is valid.
    """
    if len(data) > LONGEST:
        raise MessageError(f"a message has at most {LONGEST} bytes; this has {len(data)}")
    try:
        text = data if isinstance(data, str) else data.decode()
        request = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise MessageError(f"no JSON: {str(error)[:100]}") from None
    if not isinstance(request, dict) or not isinstance(request.get("op"), str):
        raise MessageError('valid is an object with "op", as {"op": "subscribe", ...}')
    return request


def text(request: Request, name: str) -> str:
    """Return a required text field.

    Raises:
        MessageError: it is missing, too long, or not a printable text.
    """
    value = request.get(name)
    if not isinstance(value, str) or not 0 < len(value) <= LONGEST_NAME or not value.isprintable():
        raise MessageError(f"{name} is {shown(value)}; valid is a text of 1 to {LONGEST_NAME}")
    return value


def maybe_text(request: Request, name: str) -> str | None:
    """Return a text field that may be missing or empty; then it is None."""
    return text(request, name) if request.get(name) else None


def request_id(request: Request) -> str | int | None:
    """Return the id if it can be repeated in an answer, else None."""
    result = request.get("id")
    if isinstance(result, str):
        return result if len(result) <= LONGEST_NAME and result.isprintable() else None
    return result if type(result) is int and result.bit_length() <= 64 else None


class Pieces:
    """Assembles messages that come as ``fragment`` operations."""

    def __init__(self) -> None:
        self._open: dict[str | int, dict[int, str]] = {}

    def add(self, request: Request) -> str | None:
        """Add a fragment; return the whole message once all are there, else None.

        Raises:
            MessageError: it is not a fragment, or its message is too long.
        """
        name, number, total = request_id(request), request.get("num"), request.get("total")
        data = request.get("data")
        if name is None or not isinstance(data, str):
            raise MessageError("a fragment needs id, num, total and data")
        if type(number) is not int or type(total) is not int:
            raise MessageError("a fragment's num and total are whole numbers")
        if not 0 <= number < total <= MOST_PIECES:
            raise MessageError(
                f"fragment {shown(number)} of {shown(total)}; valid are 0 to total - 1 of at most "
                f"{MOST_PIECES}"
            )
        return self._put(name, number, total, data)

    def _put(self, name: str | int, number: int, total: int, data: str) -> str | None:
        if name not in self._open and len(self._open) >= MOST_OPEN:
            del self._open[next(iter(self._open))]  # the oldest: its other fragments were lost
        pieces = self._open.setdefault(name, {})
        pieces[number] = data
        if sum(map(len, pieces.values())) > LONGEST:
            del self._open[name]
            raise MessageError(f"a message has at most {LONGEST} bytes, in all its fragments")
        if len(pieces) < total:
            return None
        del self._open[name]
        return "".join(pieces[place] for place in sorted(pieces))


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
        usual = sent_every(self.topic, self._settings)
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
