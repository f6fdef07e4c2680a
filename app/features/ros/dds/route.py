"""The topics over DDS: ``brickpose run --ros2``."""

from __future__ import annotations

import contextlib
import math
import sys
import threading
import time
from collections.abc import Iterable, Iterator
from importlib.util import find_spec

from app.engine.driver import Driver
from app.engine.mailboxes.outbox import Outbox
from app.engine.problems import CLIENTS_LOG, LOG
from app.features.ros.dds.child import Child, ChildError
from app.features.ros.dds.configuration import plan
from app.features.ros.dds.protocol import TROUBLE
from app.features.ros.inbox import Inbox
from app.features.ros.message_types import MessageError
from app.features.ros.publisher import Pace, TopicPublisher, TopicRoute, sent_every
from app.features.ros.topics import Published, Topic
from app.languages.marking import phrase
from app.settings.groups import Ros2Settings
from robot.errors import BrickPoseError, PackageError
from robot.worker_thread import WorkerThread

FIRST_WAIT_S = 1.0
LONGEST_WAIT_S = 30.0
"""Wait before the process is started again [s]: the first one and the longest; doubled each
time."""

SOUND_S = 60.0
"""A process that ran this long [s] was healthy: the next wait is the first one again."""

PAUSE_S = 0.005
"""Pause between commands, however fast they come [s]."""

TROUBLE_S = 10.0
"""A problem with a message is over when this time [s] has passed without another one."""

JOIN_S = 3.0

NO_CYCLONE = (
    "ROS 2 over DDS needs the package cyclonedds: pip install '.[ros2]' (for a Raspberry Pi, "
    "which it has no ready wheel for, docs/ros2.md says how)"
)
NOT_ON_WINDOWS = "ROS 2 over DDS is for Linux, also in WSL; here rosbridge and --foxglove serve"


class DdsRoute(TopicRoute):
    """Sends messages to the DDS process, and takes commands from it; restarts it when it fails.

    Nothing here can block the engine. Messages wait in an outbox, one per topic, until the process
    has room. A thread receives from the process. ``failure`` says what goes wrong.
    """

    name = "ROS 2 over DDS"

    def __init__(
        self, publisher: TopicPublisher, inbox: Inbox, settings: Ros2Settings, host: str
    ) -> None:
        self.refused: str | None = None
        """Why the newest command was not carried out; None if it was."""
        self.child: Child | None = None
        self.ready = threading.Event()
        """Set while a process publishes."""
        self._publisher = publisher
        self._inbox = inbox
        self._driver = Driver("ROS 2")
        self._settings = settings
        self._host = host
        self._pace = Pace(lambda topic: sent_every(topic, settings))
        self._outbox = Outbox[Published]()
        self._latched: dict[str, Published] = {}
        self._filling = threading.Lock()
        self._down: str | None = None
        self._trouble: str | None = None
        self._trouble_at = -math.inf
        self._thread = WorkerThread(
            "dds", self._keep_running, owner="DDS", patience=JOIN_S, wake=self._let_end
        )

    @property
    def failure(self) -> str | None:
        """What is wrong now, in words: with the process or, if it runs, with a message."""
        recent = time.monotonic() - self._trouble_at < TROUBLE_S
        return self._down or (self._trouble if recent else None)

    def start(self) -> None:
        """Start to publish; the process needs a second for that.

        Raises:
            PackageError: the package is missing.
            DomainError: ROS_DOMAIN_ID is not a valid domain.
        """
        if sys.platform == "win32":
            raise PackageError(NOT_ON_WINDOWS)
        if find_spec("cyclonedds") is None:
            raise PackageError(NO_CYCLONE)
        self._plan = plan(self._settings, self._host, self._inbox.incoming())
        self._numbers = {writer.topic: number for number, writer in enumerate(self._plan.writers)}
        self._thread.start()
        self._publisher.add(self)

    def wants(self, topic: Topic, stamp: float) -> bool:
        """Whether the topic is live, and its new content is due at the rate in the settings."""
        return topic.live and self._pace.due(topic, stamp)

    def take(self, published: Published) -> None:
        """Let the message wait, in place of an older one of its topic."""
        name = published.topic.name
        with self._filling:
            self._outbox.put(name, published)
            if published.topic.quality.latched:
                self._latched[name] = published

    def flush(self) -> None:
        """Send the waiting messages if the process has room; the other thread reports failures."""
        child = self.child
        if child is not None and self.ready.is_set():
            with contextlib.suppress(ChildError):
                child.offer(lambda: self._in_bytes(iter(self._outbox.take, None)))

    def close(self) -> None:
        """End the process and its thread here; may be called twice."""
        self._publisher.remove(self)
        self._thread.stop()

    def _let_end(self) -> None:
        child = self.child
        if child is not None:
            child.let_end()

    def _keep_running(self, stopping: threading.Event) -> None:
        wait = FIRST_WAIT_S
        while not stopping.is_set():
            began = time.monotonic()
            try:
                self._live(stopping)
            except (ChildError, OSError) as error:
                if stopping.is_set():
                    return
                wait = FIRST_WAIT_S if time.monotonic() - began > SOUND_S else wait
                self._down = phrase(f"{error}; it is started again in {wait:g} s")
                LOG.error(self._down)
            stopping.wait(wait)
            wait = min(2 * wait, LONGEST_WAIT_S)

    def _live(self, stopping: threading.Event) -> None:
        """Run one process from its start to its end; the end is always an error."""
        child = self.child = Child(self._plan)
        try:
            if stopping.is_set():
                return
            child.wait_until_ready()
            self._begin_anew()
            self._down, self._trouble_at = None, -math.inf
            self.ready.set()
            while True:
                if self._hear(child):
                    stopping.wait(PAUSE_S)
        finally:
            self.ready.clear()
            child.close()

    def _begin_anew(self) -> None:
        """Prepare for a new process: latched messages wait again, the others are dropped as old."""
        with self._filling:
            for _ in iter(self._outbox.take, None):
                pass
            for name, published in self._latched.items():
                self._outbox.put(name, published)

    def _in_bytes(self, messages: Iterable[Published]) -> Iterator[tuple[int, bytes]]:
        for message in messages:
            try:
                data = message.cdr
            except MessageError as error:
                self._complain(str(error))
            else:
                yield self._numbers[self._settings.full_name(message.topic.name)], data

    def _hear(self, child: Child) -> bool:
        """Carry out what the process passes on; return whether anything came."""
        came = child.receive_some()
        newest = {number: data for number, data in came if number < len(self._plan.readers)}
        for number, data in came:
            if number == TROUBLE:
                self._complain(data.decode(errors="replace"))
        for number, data in newest.items():
            self._carry_out(number, data)
        return bool(came)

    def _carry_out(self, number: int, data: bytes) -> None:
        topic = self._inbox.incoming()[number]
        try:
            self._inbox.take(topic.name, topic.type, data, self._driver)
        except BrickPoseError as error:
            self.refused = str(error)
            CLIENTS_LOG.warning("a command by DDS was refused: %s", error)
        else:
            self.refused = None

    def _complain(self, words: str) -> None:
        CLIENTS_LOG.warning("DDS: %s", words)
        self._trouble, self._trouble_at = words, time.monotonic()
