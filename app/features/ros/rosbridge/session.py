"""The session of one rosbridge client, without its socket: takes texts, gives answers, messages."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

from app.engine.driver import Driver
from app.engine.mailboxes.outbox import Outbox
from app.engine.problems import CLIENTS_LOG
from app.features.ros.encoding.navigation import ABORTED
from app.features.ros.message_types import MessageError
from app.features.ros.publisher import TopicRoute
from app.features.ros.rosbridge.actions import ActionGoal
from app.features.ros.rosbridge.bridge import PACKAGE, SET_PARAM, Bridge
from app.features.ros.rosbridge.names import check_type
from app.features.ros.rosbridge.reading import message_of
from app.features.ros.rosbridge.requests import (
    Pieces,
    Request,
    SubscribeOptions,
    Subscription,
    maybe_text,
    parse,
    request_id,
    text,
)
from app.features.ros.topics import Published, Topic
from app.features.ros.websocket_session import Data, Later
from robot.errors import BrickPoseError

MOST_BYTES = 16_000_000
"""Most bytes that wait for one client; beyond it, older messages of a name are dropped."""

MOST_WAITING = 100
"""Most messages about goals that wait for one client."""

Answers = Sequence[Request | Callable[[], Request]]
"""Answers, or what makes them in a thread."""

LEVELS = ("none", "error", "warning", "info")
"""Levels of status messages, of which a client chooses one.

Before it has, refusals are only logged, as in rosbridge_suite: its clients have no handler for a
status, whatever the protocol's text says, and roslibpy raises an exception.
"""

WATCHES = "this token only watches; ask for the link to drive"
"""Answer to commands of a client that only watches."""


class RosbridgeSession(TopicRoute):
    """A route to one client.

    ``receive`` and ``next`` are for the event loop, the other methods for any thread.
    """

    name = "rosbridge"

    def __init__(
        self,
        bridge: Bridge,
        wake: Callable[[], None],
        driver: Driver,
        *,
        watches: bool = False,
    ) -> None:
        """Start a session.

        Args:
            bridge: the objects that all sessions share.
            wake: called from the topics' thread when ``next`` has a message.
            driver: the client, as other drivers see it.
            watches: whether the client only watches: its commands are refused.
        """
        self._bridge = bridge
        self._wake = wake
        self._driver = driver
        self._watches = watches
        self._level = "none"
        self._outbox = Outbox[Data](MOST_BYTES)
        self._pieces = Pieces()
        self._subscriptions: dict[str, Subscription] = {}
        self._by_topic: dict[str, tuple[Subscription, ...]] = {}
        self._due: list[Subscription] = []
        self._holds = False
        self._goals: dict[str | int | None, ActionGoal] = {}
        """By the ids that the client gave them."""
        self._operations: dict[str, Callable[[Request], Answers]] = {
            "advertise": self._advertise,
            "unadvertise": self._nothing,
            "publish": self._publish,
            "subscribe": self._subscribe,
            "unsubscribe": self._unsubscribe,
            "call_service": self._call_service,
            "send_action_goal": self._send_action_goal,
            "cancel_action_goal": self._cancel_action_goal,
            "set_level": self._set_level,
            "status_level": self._set_level,
            "fragment": self._fragment,
            "auth": self._nothing,
            "status": self._nothing,
        }

    def receive(self, data: Data) -> list[Data | Later]:
        """Carry out a message; return the answers to send. An invalid message raises nothing."""
        request: Request = {}
        answers: Answers
        try:
            request = parse(data)
            answers = self._do(request)
        except BrickPoseError as error:
            answers = self._status(request, str(error))
        return [_later(answer) if callable(answer) else _in_json(answer) for answer in answers]

    def next(self) -> Data | None:
        """The next message for the client; None if nothing waits."""
        return self._outbox.take()

    def close(self) -> None:
        """End all subscriptions; stop the robot if this client drives it and nobody else does."""
        self._bridge.publisher.remove(self)
        self._by_topic = {}
        self._hold_the_clock(False)
        self._bridge.inbox.drivers.leave(self._driver)
        for goal in self._goals.values():
            goal.close()

    def wants(self, topic: Topic, stamp: float) -> bool:
        """Whether one of the client's subscriptions to the topic is due."""
        subscriptions = self._by_topic.get(topic.name, ())
        # Ask all of them: each one that is due counts the content as sent.
        self._due = [subscription for subscription in subscriptions if subscription.due(stamp)]
        return bool(self._due)

    def take(self, published: Published) -> None:
        """Put the message into the outbox, where the event loop finds it."""
        for item in self._due:
            data = self._bridge.encoder.encode(published, item.name, item.compression)
            self._outbox.put(item.name, data, item.queue, len(data))
        self._wake()

    def _do(self, request: Request) -> Answers:
        operation = self._operations.get(request["op"])
        if operation is None:
            valid = ", ".join(self._operations)
            raise MessageError(f"{request['op'][:60]!r} is no operation here; valid are {valid}")
        return operation(request)

    def _status(self, request: Request, words: str, level: str = "error") -> list[Request]:
        if LEVELS.index(level) > LEVELS.index(self._level):
            CLIENTS_LOG.warning("rosbridge refuses what %s asks: %s", self._driver.name, words)
            return []
        return [_with_id(request, {"op": "status", "level": level, "msg": words})]

    def _nothing(self, request: Request) -> list[Request]:
        """Accept an operation that has no effect here."""
        return []

    def _advertise(self, request: Request) -> list[Request]:
        self._bridge.names.incoming_topic(text(request, "topic"), maybe_text(request, "type"))
        return []

    def _publish(self, request: Request) -> list[Request]:
        topic = self._bridge.names.incoming_topic(text(request, "topic"), None)
        self._refuse_watchers()
        try:
            message = message_of(request.get("msg", {}), topic.type)
        except MessageError:
            self._bridge.inbox.refuse(topic.name, self._driver)
            raise
        self._bridge.inbox.take(topic.name, topic.type, message, self._driver)
        return []

    def _refuse_watchers(self) -> None:
        if self._watches:
            raise MessageError(WATCHES)

    def _subscribe(self, request: Request) -> list[Request]:
        name = text(request, "topic")
        topic = self._bridge.names.heard(name, maybe_text(request, "type"))
        wish = SubscribeOptions.of(request)
        known = self._subscriptions.get(name)
        subscription = known or Subscription(name, topic, self._bridge.names.settings)
        subscription.add(request_id(request), wish)
        if known is None:
            self._subscriptions[name] = subscription
            self._sort()
        self._hold_the_clock(self._holds or wish.every)
        return []

    def _unsubscribe(self, request: Request) -> list[Request]:
        name = text(request, "topic")
        subscription = self._subscriptions.get(name)
        if subscription is None:
            raise MessageError(f"{name} is not subscribed")
        if subscription.remove(request_id(request)):
            del self._subscriptions[name]
            self._sort()
            self._outbox.drop(name)
        return []

    def _sort(self) -> None:
        """Sort subscriptions by topic; register as a route only while there are any.

        Each tick asks all routes, which costs time.
        """
        before = self._by_topic
        after: dict[str, tuple[Subscription, ...]] = {}
        for subscription in self._subscriptions.values():
            after[subscription.topic.name] = (*after.get(subscription.topic.name, ()), subscription)
        self._by_topic = after
        self._hold_the_clock(self._holds and bool(after))
        if after and not before:
            self._bridge.publisher.add(self)
        elif before and not after:
            self._bridge.publisher.remove(self)

    def _hold_the_clock(self, wanted: bool) -> None:
        """Hold or release the clock: a recording has one time base, even if the clock is set."""
        clock = self._bridge.publisher.source.clock
        if wanted and not self._holds:
            clock.hold()
        elif self._holds and not wanted:
            clock.release()
        self._holds = wanted

    def _call_service(self, request: Request) -> Answers:
        name = text(request, "service")
        service = self._bridge.names.service(name)
        if service is not None and service.slow:
            return [partial(self._service_answer, name, request)]
        return [self._service_answer(name, request)]

    def _service_answer(self, name: str, request: Request) -> Request:
        answer: Request = {"op": "service_response", "service": name}
        try:
            answer |= {"values": self._called(name, request), "result": True}
        except BrickPoseError as error:
            answer |= {"values": str(error), "result": False}
        return _with_id(request, answer)

    def _called(self, name: str, request: Request) -> Any:
        arguments = request.get("args")
        arguments = {} if arguments is None else arguments
        if name.lstrip("/") == f"{PACKAGE}/{SET_PARAM}":
            self._refuse_watchers()
            return self._bridge.rosapi.set_parameter(arguments, self._driver)
        given = self._bridge.rosapi.call(name, arguments)
        if given is not None:
            return given
        service = self._bridge.service(name)
        self._refuse_watchers()
        check_type(service, maybe_text(request, "type"))
        message = self._bridge.request_of(service, arguments)
        return self._bridge.inbox.call(service.name, message, self._driver)

    def _send_action_goal(self, request: Request) -> list[Request]:
        name, number = text(request, "action"), request_id(request)
        action = self._bridge.action(name)
        answer: Request = {"action": name} if number is None else {"action": name, "id": number}
        arguments = request.get("args")
        wants_feedback = request.get("feedback") is True

        def feedback(values: Request) -> None:
            if wants_feedback:
                self._send({"op": "action_feedback", **answer, "values": values})

        def ended(status: int, values: Request) -> None:
            result = {"op": "action_result", **answer, "values": values}
            self._send({**result, "status": status, "result": True})

        goal = ActionGoal(action, self._bridge.inbox, self._driver, feedback, ended)
        try:
            self._refuse_watchers()
            goal.begin(arguments if isinstance(arguments, dict) else {})
        except BrickPoseError as error:
            refused = {"values": str(error), "status": ABORTED, "result": False}
            return [{"op": "action_result", **answer, **refused}]
        self._goals = {key: each for key, each in self._goals.items() if each.watched}
        self._goals[number] = goal
        return []

    def _cancel_action_goal(self, request: Request) -> list[Request]:
        goal = self._goals.get(request_id(request))
        if goal is None or not goal.watched:
            raise MessageError("there is no goal with this id; valid is that of send_action_goal")
        goal.cancel()
        return []

    def _send(self, message: Request) -> None:
        """Send what comes later, from any thread."""
        data = _in_json(message)
        self._outbox.put("", data, MOST_WAITING, len(data))
        self._wake()

    def _set_level(self, request: Request) -> list[Request]:
        level = text(request, "level")
        if level not in LEVELS:
            raise MessageError(f"level is {level!r}; valid are {', '.join(LEVELS)}")
        self._level = level
        return []

    def _fragment(self, request: Request) -> Answers:
        whole = self._pieces.add(request)
        if whole is None:
            return []
        request = parse(whole)
        if request["op"] == "fragment":
            raise MessageError("a fragment's message is no fragment itself")
        return self._do(request)


def _in_json(answer: Request) -> str:
    return json.dumps(answer, separators=(",", ":"), allow_nan=False)


def _later(answer: Callable[[], Request]) -> Later:
    return lambda: _in_json(answer())


def _with_id(request: Request, answer: Request) -> Request:
    result = request_id(request)
    return answer if result is None else {**answer, "id": result}
