"""TickSender: sends the snapshots of an engine to the server, as many as it needs."""

from __future__ import annotations

import threading
from collections.abc import Callable
from contextlib import ExitStack

from app.engine.engine import Engine
from app.engine.mailboxes.backlog import Backlog
from app.engine.mailboxes.latest import Latest
from app.engine.mailboxes.rhythm import Rhythm
from app.engine.snapshot import Snapshot
from app.features.control.messages import Hangs, SentTick, Watched

UNWATCHED_S = 0.2
"""Interval of snapshots while nobody looks [s]: for whoever comes next, and for health.

Without a tick for this time the server is told where the loop hangs."""
MOST_WAITING = 500
"""Snapshots that wait to be sent to whoever needs each one: ten seconds of them."""


class TickSender:
    """Sends in a thread of its own: the loop never waits for the server."""

    def __init__(
        self,
        engine: Engine,
        loop: int,
        watched: Callable[[], Watched],
        send: Callable[[object], None],
    ) -> None:
        """Begin to send.

        Args:
            engine: whose snapshots are sent; its mailbox is replaced.
            loop: the ``ident`` of the thread that runs it.
            watched: returns who looks now.
            send: sends a message.
        """
        self._engine = engine
        self._loop = loop
        self._watched = watched
        self._send = send
        self._woken = threading.Event()
        self._done = threading.Event()
        self._each: Backlog[Snapshot] | None = None
        self._rhythm = Rhythm()
        engine.latest = _AnnouncedLatest(self._announce)
        self._thread = threading.Thread(target=self._work, name="ticks", daemon=True)
        self._thread.start()

    def finish(self, patience: float) -> None:
        """Send the last snapshot, and end; wait for that no longer than ``patience`` [s]."""
        self._done.set()
        self._woken.set()
        self._thread.join(patience)

    def look(self) -> None:
        """Look at once who watches now."""
        self._woken.set()

    def _announce(self, newest: Snapshot) -> None:
        """Have the newest snapshot sent, if somebody waits for it; called by the loop."""
        watched, stamp = self._watched(), newest.published
        pictured = newest.reading.frame is not None
        if watched.rate > 0 and (pictured or self._rhythm.wait(stamp) <= 0):
            self._rhythm.choose(stamp, watched.rate)
            self._woken.set()
        elif watched.every:
            self._woken.set()

    def _work(self) -> None:
        count, hangs = 0, False
        with ExitStack() as subscription:
            over = False
            while not over:
                woken = self._woken.wait(UNWATCHED_S)
                self._woken.clear()
                over = self._done.is_set()
                self._subscribe(self._watched(), subscription)
                before, count = count, self._send_new(count)
                if count > before:
                    hangs = False
                elif not (woken or hangs):
                    hangs = True
                    self._send(Hangs(tuple(self._engine.where_it_hangs(self._loop))))

    def _subscribe(self, watched: Watched, subscription: ExitStack) -> None:
        """Have the engine know who looks: its camera rests while nobody does."""
        if watched.every and self._each is None:
            every = self._engine.every
            self._each = subscription.enter_context(every.subscribe(MOST_WAITING))
        elif not watched.every and self._each is not None:
            subscription.close()
            self._each = None
        if watched.rate > 0:
            self._engine.audience.visit()

    def _send_new(self, count: int) -> int:
        """Send what is new since snapshot number ``count``; return the number of the newest."""
        newer = self._engine.latest.newer_than(count)
        waiting = iter(self._each.get, None) if self._each else ()
        last = None
        for last in waiting:
            self._send(SentTick(last, unbroken=True))
        if newer is None:
            return count
        if newer[1] is not last:  # also what is put after the last tick: that the loop has failed
            self._send(SentTick(newer[1], unbroken=False))
        return newer[0]


class _AnnouncedLatest(Latest[Snapshot]):
    """A mailbox that also tells a thread."""

    def __init__(self, announce: Callable[[Snapshot], None]) -> None:
        super().__init__()
        self._announce = announce

    def put(self, value: Snapshot) -> None:
        """Replace the value, wake coroutines, and tell it."""
        super().put(value)
        self._announce(value)
