"""The child process that speaks DDS, as the program sees it: one run."""

from __future__ import annotations

import contextlib
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterable, Iterator
from typing import BinaryIO

from app.engine.problems import CLIENTS_LOG
from app.features.ros.dds.protocol import (
    ALIVE,
    ALIVE_S,
    PLAN,
    READY,
    WORDS,
    Frames,
    FramingError,
    Plan,
    header,
)
from robot.errors import BrickPoseError

COMMAND = (sys.executable, "-m", "app.features.ros.dds.process")

START_S = 30.0
"""Longest time until the process publishes [s]; a Pi takes 2."""

SILENCE_S = 5 * ALIVE_S
"""Longest time without a sign of life [s]."""

END_S = 2.0
PIPE_BYTES = 256 * 1024
LONGEST_IN = 64 * 1024
LONGEST_LINE = 500
CHUNK = 16 * 1024


class ChildError(BrickPoseError, RuntimeError):
    """The process ended or failed; says how."""


class Child:
    """Starts the process; ``close`` ends it. One thread offers messages, another receives them."""

    def __init__(self, plan: Plan) -> None:
        self._plan = plan
        self._end, its = socket.socketpair()
        with its, contextlib.ExitStack() as on_failure:
            on_failure.enter_context(self._end)
            for end in (self._end, its):
                end.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, PIPE_BYTES)
            self._out = on_failure.enter_context(self._end.dup())
            """The same socket, for sending without blocking."""
            self.process = subprocess.Popen(
                [*COMMAND, str(its.fileno())],
                pass_fds=(its.fileno(),),
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.PIPE,
                start_new_session=True,  # Ctrl-C is for the program, which then ends it
            )
            on_failure.pop_all()
        assert self.process.stderr is not None
        self._complaints = threading.Thread(
            target=_log, args=(self.process.stderr,), name="complaints of DDS", daemon=True
        )
        self._complaints.start()
        self._end.settimeout(START_S)
        self._out.setblocking(False)
        self._rest = bytearray()
        """The offered bytes that are not sent yet, because the pipe was full."""
        self._took = 0.0
        """When the process last took something, on the computer's monotonic clock [s]."""
        self._sending = threading.Lock()
        self._frames = Frames(LONGEST_IN)
        self._cause: str | None = None
        self._words: str | None = None

    def send(self, number: int, payload: bytes) -> None:
        """Send a message; waits until all of it is in the pipe.

        Raises:
            ChildError: the process takes nothing, or has ended.
        """
        try:
            self._end.sendall(header(number, payload) + payload)
        except OSError as error:
            raise self._error() from error

    def offer(self, messages: Callable[[], Iterable[tuple[int, bytes]]]) -> None:
        """Send messages in one piece without waiting; ``messages`` is called only if there is room.

        Raises:
            ChildError: the process takes nothing, or has ended.
        """
        try:
            with self._sending:
                if self._push(b""):
                    self._push(b"".join(header(n, data) + data for n, data in messages()))
        except OSError as error:
            # The receiving thread waits for the end of the process and reports its full cause.
            raise ChildError(f"the DDS process: {self._cause or 'it has ended'}") from error

    def _push(self, data: bytes) -> bool:
        """Send as much as fits into the pipe; return whether everything is sent."""
        if not self._rest:
            self._took = time.monotonic()
        self._rest += data
        while self._rest:
            try:
                sent = self._out.send(self._rest)
            except BlockingIOError:
                if time.monotonic() - self._took > SILENCE_S:
                    self.kill(f"it took nothing for {SILENCE_S:g} s")
                return False
            del self._rest[:sent]
            self._took = time.monotonic()
        return True

    def wait_until_ready(self) -> None:
        """Send the process its plan, and wait until it publishes.

        Raises:
            ChildError: it does not start to publish.
        """
        with contextlib.suppress(ChildError):  # it has ended: what it sent before says why
            self.send(PLAN, self._plan.to_json())
        for number, _ in self.receive():
            if number == READY:
                self._end.settimeout(SILENCE_S)
                return

    def receive(self) -> Iterator[tuple[int, bytes]]:
        """Yield messages as they come, without signs of life; never ends.

        Raises:
            ChildError: the process is silent, ends, or sends invalid data.
        """
        while True:
            yield from self.receive_some()

    def receive_some(self) -> list[tuple[int, bytes]]:
        """Return the messages in the next few kilobytes; raises the errors of ``receive``."""
        try:
            data = self._end.recv(CHUNK)
            came = list(self._frames.feed(data))
        except TimeoutError:
            self.kill("it does not answer")
            raise self._error() from None
        except FramingError as error:
            self.kill(f"it sent {error}")
            raise self._error() from error
        except OSError as error:
            raise self._error() from error
        for number, payload in came:
            if number == WORDS:
                self._words = payload.decode(errors="replace")
        if not data:
            raise self._error()
        return [(number, payload) for number, payload in came if number not in (ALIVE, WORDS)]

    def kill(self, cause: str) -> None:
        """Kill the process at once, even if it is suspended; ``cause`` is reported."""
        self._cause = self._cause or cause
        self.process.kill()

    def let_end(self) -> None:
        """Close the connection, from any thread.

        The process ends, and threads that send or receive here get an error.
        """
        with contextlib.suppress(OSError):
            self._end.shutdown(socket.SHUT_RDWR)

    def close(self) -> None:
        """Make sure that the process ends; call it when no thread sends or receives any more."""
        self.let_end()
        try:
            self.process.wait(END_S)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
        self._complaints.join(END_S)
        with self._sending:
            self._out.close()
        self._end.close()

    def _error(self) -> ChildError:
        """Wait for the process to end, and return an error with the cause."""
        with contextlib.suppress(subprocess.TimeoutExpired):
            self.process.wait(END_S)
        return ChildError(f"the DDS process: {self._cause or self._words or self._ending()}")

    def _ending(self) -> str:
        code = self.process.returncode
        if code is None:
            return "it closed its connection"
        if code == 0:
            return "it ended"
        if code < 0:
            return f"it was ended by {signal.Signals(-code).name}"
        return f"it ended with {code}"


def _log(complaints: BinaryIO) -> None:
    """Log what Cyclone DDS complains of, which any peer can make it do with each of its messages.

    A few lines a minute are enough, of whatever kind: the peer chooses the words.
    """
    with complaints:
        while line := complaints.readline(LONGEST_LINE):
            words = line.decode(errors="replace").strip()
            CLIENTS_LOG.warning("DDS: %s", "".join(c if c.isprintable() else "?" for c in words))
