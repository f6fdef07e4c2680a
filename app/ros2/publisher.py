"""Makes each message once and hands it to the routes that want it."""

from __future__ import annotations

import threading
import time

from app.engine.mailboxes.broadcast import Broadcast
from app.engine.problems import LOG
from app.engine.snapshot import Snapshot
from app.ros2.message_types import MessageError
from app.ros2.published import Published
from app.ros2.route import Route
from app.ros2.source import TopicSource
from app.ros2.topic import Topic
from app.ros2.topics import TOPICS

MOST_WAITING = 500
"""Ticks: ten seconds and less, in which this thread got no time at all."""

LOOK_S = 0.2
"""Between two looks at whether to end, while there are no ticks [s]."""

JOIN_S = 2.0
SHOWN_S = 60.0
"""A failure is shown so long: a client that is gone concerns nobody for ever [s]."""


class TopicPublisher:
    """A thread of its own, so that no message is made in the engine's; it runs while routes are."""

    def __init__(self, source: TopicSource, every: Broadcast[Snapshot]) -> None:
        self.source = source
        self.lost = 0
        """Ticks that came while too many waited already."""
        self._failure: tuple[float, str] | None = None
        self._every = every
        self._routes: tuple[Route, ...] = ()
        self._lock = threading.Lock()
        self._thread: threading.Thread | None = None

    def add(self, route: Route) -> None:
        """Let a route have what it wants, from the next tick on."""
        with self._lock:
            self._routes = (*self._routes, route)
            if self._thread is None:
                self._thread = threading.Thread(target=self._run, name="topics", daemon=True)
                self._thread.start()

    def remove(self, route: Route) -> None:
        """Let it have nothing more; the thread ends after the last route."""
        with self._lock:
            self._routes = tuple(item for item in self._routes if item is not route)

    @property
    def failure(self) -> str | None:
        """Which route or topic failed lately, and why."""
        if self._failure is None or time.monotonic() - self._failure[0] > SHOWN_S:
            return None
        return self._failure[1]

    def close(self) -> None:
        """Let all routes go, and wait for the thread."""
        with self._lock:
            self._routes = ()
            thread = self._thread
        if thread is not None and thread is not threading.current_thread():
            thread.join(JOIN_S)
            if thread.is_alive():
                LOG.error("the topics' thread did not end within %g s", JOIN_S)

    def _run(self) -> None:
        with self._every.subscribe(MOST_WAITING) as feed:
            while self._goes_on():
                snapshot = feed.get(LOOK_S)
                while snapshot is not None and self._routes:
                    self.lost = feed.lost
                    self.source.clock.follow(snapshot)
                    for topic in TOPICS:
                        self.publish(topic, snapshot)
                    self._flush()
                    snapshot = feed.get(0.0)
                # Ticks that are taken several at a time cost two thirds of those taken one by one.
                time.sleep(min((route.patience for route in self._routes), default=0.0))

    def _goes_on(self) -> bool:
        """Whether there are routes. It decides itself: two threads must never ask one route."""
        with self._lock:
            if not self._routes:
                self._thread = None
            return bool(self._routes)

    def publish(self, topic: Topic, snapshot: Snapshot) -> None:
        """Hand a topic's message of a tick to all routes that want it now."""
        try:
            stamp = topic.stamp(snapshot)
            takers = (
                [] if stamp is None else [r for r in self._routes if self._asks(r, topic, stamp)]
            )
            if stamp is None or not takers:
                return
            published = Published(topic, stamp, self.source, snapshot)
        except Exception as error:
            self._complain(topic.name, error)
            return
        for route in takers:
            try:
                route.take(published)
            except MessageError as error:
                self._complain(topic.name, error)  # one topic, not the route
            except Exception as error:
                self._end(route, error)

    def _flush(self) -> None:
        for route in self._routes:
            try:
                route.flush()
            except Exception as error:
                self._end(route, error)

    def _asks(self, route: Route, topic: Topic, stamp: float) -> bool:
        try:
            return route.wants(topic, stamp)
        except Exception as error:
            self._end(route, error)
            return False

    def _end(self, route: Route, error: Exception) -> None:
        self.remove(route)
        self._complain(route.name, error)

    def _complain(self, what: str, error: Exception) -> None:
        message = f"{what} failed: {error}"
        if message != self.failure:
            LOG.exception(message)
        self._failure = (time.monotonic(), message)
