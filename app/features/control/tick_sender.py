"""TickSender: sends the snapshots of an engine to the server, as many as it needs."""

from __future__ import annotations

import threading
from collections.abc import Callable
from contextlib import ExitStack

from app.engine.engine import Engine
from app.engine.mailboxes.backlog import Backlog
from app.engine.snapshot import Snapshot
from app.features.control.announced import AnnouncedLatest
from app.features.control.messages import Hangs, SentTick, Watched

HANGS_S = 0.5
"""Without a snapshot for this time the server is told where the loop hangs [s]; while nobody looks,
one is published in 0.2 s."""
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
        self._rate = 0.0
        """At which the engine's audience has somebody for the server [1/s]."""
        engine.latest = AnnouncedLatest(self._woken.set)
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

    def _work(self) -> None:
        count, hangs = 0, False
        with ExitStack() as subscription:
            over = False
            while not over:
                woken = self._woken.wait(HANGS_S)
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
        """Have the engine know who looks: it makes no snapshots that nobody needs."""
        if watched.every and self._each is None:
            every = self._engine.every
            self._each = subscription.enter_context(every.subscribe(MOST_WAITING))
        elif not watched.every and self._each is not None:
            subscription.close()
            self._each = None
        if watched.rate != self._rate:
            audience = self._engine.audience
            if watched.rate > 0:
                audience.join(watched.rate)
            if self._rate > 0:
                audience.leave(self._rate)
            self._rate = watched.rate

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
