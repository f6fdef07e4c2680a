"""The session of one Foxglove viewer, without its socket: takes messages, gives answers, topics."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from app.engine.driver import Driver
from app.engine.mailboxes.outbox import Outbox
from app.features.ros.foxglove.offer import Commands, Offer
from app.features.ros.foxglove.protocol import (
    ERROR,
    Advertise,
    ClientMessage,
    ServiceCall,
    Subscribe,
    Unadvertise,
    Unsubscribe,
    Wish,
    Words,
    message_data,
    parse,
    service_response,
    words,
)
from app.features.ros.message_types import MessageError
from app.features.ros.publisher import Pace, TopicRoute, sent_every
from app.features.ros.topics import Published, Topic
from app.features.ros.websocket_session import Data, Later
from robot.errors import BrickPoseError

MOST_BYTES = 16_000_000
"""Most bytes that wait for one viewer; beyond it, older messages of a topic are dropped."""


class FoxgloveSession(TopicRoute):
    """A route to one viewer; a topic is made only while a viewer subscribes to it.

    ``receive`` and ``next`` are for the event loop, the other methods for any thread.
    """

    name = "Foxglove"

    def __init__(
        self, offer: Offer, wake: Callable[[], None], driver: Driver, refusal: str | None
    ) -> None:
        """Start a session.

        Args:
            wake: called from the topics' thread when ``next`` has a message.
            driver: the viewer, as other drivers see it.
            refusal: why its commands are refused; None if it may send some.
        """
        self._offer = offer
        self._wake = wake
        self._driver = driver
        self._refusal = refusal
        self._commands = Commands(offer.inbox, offer.names, driver)
        self._outbox = Outbox[Data](MOST_BYTES)
        self._subscriptions: dict[str, tuple[int, Pace]] = {}
        """Number and pace by topic; replaced when it changes, as other threads read it."""

    def receive(self, data: Data) -> list[Data | Later]:
        """Carry out a message; return the answers to send. An invalid message raises nothing.

        What is invalid in a list does not keep the rest of it from being carried out.
        """
        try:
            request = parse(data)
            if isinstance(request, ServiceCall):
                slow = self._commands.is_slow(request)
                return [partial(self._answer, request) if slow else self._answer(request)]
            steps = self._steps(request)
        except BrickPoseError as error:
            return [_complaint(error)]
        return [answer for step in steps for answer in _carried_out(step)]

    def next(self) -> Data | None:
        """The next message for the viewer; None if nothing waits."""
        return self._outbox.take()

    def close(self) -> None:
        """End all subscriptions; stop the robot if this viewer drives it and nobody else does."""
        self._replace({})
        self._offer.inbox.drivers.leave(self._driver)

    def wants(self, topic: Topic, stamp: float) -> bool:
        """Whether the viewer subscribes to the topic, and its content is due."""
        subscription = self._subscriptions.get(topic.name)
        return subscription is not None and subscription[1].due(topic, stamp)

    def take(self, published: Published) -> None:
        """Put the message into the outbox, where the event loop finds it."""
        topic = published.topic
        subscription = self._subscriptions.get(topic.name)
        if subscription is None:
            return  # it has just ended
        data = message_data(subscription[0], published.log_time_ns, published.cdr)
        self._outbox.put(topic.name, data, topic.quality.depth, len(data))
        self._wake()

    def _answer(self, call: ServiceCall) -> Data:
        try:
            self._check_commands()
            return service_response(call, self._commands.call(call))
        except BrickPoseError as error:
            return words(
                "serviceCallFailure", serviceId=call.service, callId=call.call, message=str(error)
            )

    def _steps(self, request: Words | ClientMessage) -> list[Callable[[], None]]:
        """Return what a message asks for, item by item.

        Raises:
            MessageError: it is a command, and the viewer may give none.
        """
        if isinstance(request, Subscribe):
            return [partial(self._subscribe, wish) for wish in request.subscriptions]
        if isinstance(request, Unsubscribe):
            return [partial(self._unsubscribe, frozenset(request.subscriptions))]
        self._check_commands()
        if isinstance(request, Advertise):
            return [partial(self._commands.advertise, channel) for channel in request.channels]
        if isinstance(request, Unadvertise):
            return [partial(self._commands.unadvertise, number) for number in request.channels]
        return [partial(self._commands.take, request)]

    def _check_commands(self) -> None:
        if self._refusal is not None:
            raise MessageError(self._refusal)

    def _subscribe(self, wish: Wish) -> None:
        topics = self._offer.topics
        if wish.channel >= len(topics):
            raise MessageError(f"channel {wish.channel} is not among those advertised")
        topic, settings = topics[wish.channel], self._offer.names.settings
        if topic.name in self._subscriptions:
            raise MessageError(f"{settings.full_name(topic.name)} is subscribed already")
        # A new pace has no history: late viewers get what is latched.
        pace = Pace(lambda topic: sent_every(topic, settings))
        self._replace({**self._subscriptions, topic.name: (wish.id, pace)})

    def _unsubscribe(self, numbers: frozenset[int]) -> None:
        ended = {name for name, (number, _) in self._subscriptions.items() if number in numbers}
        kept = {name: item for name, item in self._subscriptions.items() if name not in ended}
        self._replace(kept)
        for name in ended:
            self._outbox.drop(name)

    def _replace(self, subscriptions: dict[str, tuple[int, Pace]]) -> None:
        """Change what is subscribed; a route only while there is any: each tick asks all routes."""
        before, self._subscriptions = self._subscriptions, subscriptions
        if subscriptions and not before:
            self._offer.publisher.add(self)
        elif before and not subscriptions:
            self._offer.publisher.remove(self)


def _carried_out(step: Callable[[], None]) -> list[Data]:
    """Carry out one item of a message; return the answer if it is not possible."""
    try:
        step()
    except BrickPoseError as error:
        return [_complaint(error)]
    return []


def _complaint(error: BrickPoseError) -> Data:
    return words("status", level=ERROR, message=str(error))
