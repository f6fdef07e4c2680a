"""Makes each message once, and hands it to the routes that want it."""

from __future__ import annotations

import threading
import time
from abc import ABC, abstractmethod
from collections.abc import Callable
from contextlib import ExitStack

from app.engine.mailboxes.backlog import Backlog
from app.engine.mailboxes.broadcast import Broadcast
from app.engine.problems import LOG
from app.engine.snapshot import Snapshot
from app.feature_search import reason_of
from app.features.ros.message_types import MessageError
from app.features.ros.source import TopicSource
from app.features.ros.topics import Published, Topic, feature_of, topics
from app.languages.marking import phrase
from app.settings.groups import Ros2Settings
from robot.worker_thread import WorkerThread

SLACK = 0.001
"""Tolerance for content that is nearly due, as ticks come a little early or late [s]."""
MOST_WAITING = 500
"""Most ticks that wait: at most ten seconds of them, if this thread gets no time at all."""
LOOK_S = 0.2
"""Interval of checking whether to end, while there are no ticks [s]."""
JOIN_S = 2.0
SHOWN_S = 60.0
"""How long a failure is shown [s]: that of a client that has left soon becomes irrelevant."""


class TopicRoute(ABC):
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
            topic: one of ``topics()``.
            stamp: stamp of the content, on the robot's clock [s].
        """

    @abstractmethod
    def take(self, published: Published) -> None:
        """Take a message, in the topics' thread; must not wait for anything."""

    def flush(self) -> None:  # noqa: B027 most have nothing to do
        """Pass the taken messages on; called at the end of a tick. Must not wait either."""


def sent_every(topic: Topic, settings: Ros2Settings) -> float:
    """Return the least time between two messages of a topic [s]; 0: no limit."""
    return 0.0 if topic.rate is None else 1.0 / getattr(settings, topic.rate)


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


class TopicPublisher:
    """Makes messages in its own thread, not in the engine's. The thread runs while routes exist."""

    def __init__(self, source: TopicSource, every: Broadcast[Snapshot]) -> None:
        self.source = source
        self.lost = 0
        """Ticks that were dropped because too many waited already."""
        self._failures: dict[str, tuple[float, str]] = {}
        """When and why each route or topic failed last, by its name."""
        self._left_out: dict[str, str] = {}
        """Why topics of features are not made any more, by their names."""
        self._every = every
        self._routes: tuple[TopicRoute, ...] = ()
        self._lock = threading.Lock()
        self._thread: WorkerThread | None = None

    def add(self, route: TopicRoute) -> None:
        """Add a route; it gets messages from the next tick on."""
        with self._lock:
            self._routes = (*self._routes, route)
            if self._thread is None:
                # Subscribed here: the thread may begin only after the next tick.
                subscribed = ExitStack()
                feed = subscribed.enter_context(self._every.subscribe(MOST_WAITING))
                self._thread = WorkerThread(
                    "topics",
                    lambda stopping: self._run(subscribed, feed),
                    owner="the topics",
                    patience=JOIN_S,
                )
                self._thread.start()

    def remove(self, route: TopicRoute) -> None:
        """Remove a route; the thread ends after the last one."""
        with self._lock:
            self._routes = tuple(item for item in self._routes if item is not route)

    @property
    def failures(self) -> tuple[str, ...]:
        """Which routes and topics failed in the last ``SHOWN_S`` seconds, or are left out."""
        since = time.monotonic() - SHOWN_S
        shown = (words for time_s, words in tuple(self._failures.values()) if time_s > since)
        return (*tuple(self._left_out.values()), *shown)

    def close(self) -> None:
        """Remove all routes, and wait for the thread to end."""
        with self._lock:
            self._routes = ()
            thread = self._thread
        if thread is not None:
            thread.join()

    def _run(self, subscribed: ExitStack, feed: Backlog[Snapshot]) -> None:
        with subscribed:
            while self._goes_on():
                snapshot = feed.get(LOOK_S)
                while snapshot is not None and self._routes:
                    self.lost = feed.lost
                    self.source.clock.follow(snapshot)
                    for topic in topics():
                        self.publish(topic, snapshot)
                    self._flush()
                    snapshot = feed.get(0.0)
                # Taking several ticks at a time costs two thirds of taking them one by one.
                time.sleep(min((route.patience for route in self._routes), default=0.0))

    def _goes_on(self) -> bool:
        """Whether there are routes; if there are none, clear ``_thread``.

        Both happen under one lock: two threads must never ask the same route.
        """
        with self._lock:
            if not self._routes:
                self._thread = None
            return bool(self._routes)

    def publish(self, topic: Topic, snapshot: Snapshot) -> None:
        """Make a topic's message of a tick, and hand it to all routes that want it now."""
        if topic.name in self._left_out:
            return
        try:
            stamp = topic.stamp(snapshot)
            takers = (
                [] if stamp is None else [r for r in self._routes if self._asks(r, topic, stamp)]
            )
            if stamp is None or not takers:
                return
            published = Published(topic, stamp, self.source, snapshot)
        except Exception as error:
            self._blame(topic, error)
            return
        for route in takers:
            try:
                route.take(published)
            except MessageError as error:
                self._blame(topic, error)  # only the topic fails, not the route
            except Exception as error:
                self._end(route, error)

    def _flush(self) -> None:
        for route in self._routes:
            try:
                route.flush()
            except Exception as error:
                self._end(route, error)

    def _asks(self, route: TopicRoute, topic: Topic, stamp: float) -> bool:
        try:
            return route.wants(topic, stamp)
        except Exception as error:
            self._end(route, error)
            return False

    def _end(self, route: TopicRoute, error: Exception) -> None:
        self.remove(route)
        self._complain(route.name, error)

    def _blame(self, topic: Topic, error: Exception) -> None:
        """Name a topic that failed; one of a feature is left out from now on."""
        feature, name = feature_of(topic), topic.name
        if feature is None:
            self._complain(name, error)
            return
        LOG.exception("the topic %s of the feature %s failed", name, feature)
        why = reason_of(error)
        self._left_out[name] = phrase(
            f"The topic {name} of the feature {feature} is left out: {why}."
        )

    def _complain(self, name: str, error: Exception) -> None:
        message = f"{name} failed: {reason_of(error)}"
        if message not in self.failures:
            LOG.exception(message)
        self._failures[name] = (time.monotonic(), message)
