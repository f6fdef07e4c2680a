"""Answers each line of text with one line: on a Unix socket, and on standard input."""

from __future__ import annotations

import os
import socket
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

from robot.errors import CommandError
from sim.hat_emulator.emulator import RealTimeBoard
from sim.hat_emulator.pseudo_terminal import listen, stop_listening

LONGEST_LINE = 4096
"""Longest line [bytes]; a client that sends more without a line end is disconnected."""


class Lines:
    """Splits received bytes into lines and answers them."""

    def __init__(self, answer: Callable[[str], str]) -> None:
        self._answer = answer
        self._begun = b""

    def feed(self, data: bytes) -> bytes:
        """Take bytes; return the answers to the lines that are now complete.

        Raises:
            CommandError: a line is too long.
        """
        *lines, self._begun = (self._begun + data).split(b"\n")
        if len(self._begun) > LONGEST_LINE:
            raise CommandError(f"a line is longer than {LONGEST_LINE} bytes")
        texts = (line.decode("utf-8", "replace").strip() for line in lines)
        return b"".join(self._answer(text).encode() + b"\n" for text in texts if text)


class LineServer:
    """Server of lines; any number of programs may connect, also at the same time."""

    def __init__(self, path: Path, answer: Callable[[str], str], loop: RealTimeBoard) -> None:
        """Listen at ``path``.

        Raises:
            PortError: it cannot listen there.
        """
        self._answer = answer
        self._loop = loop
        self._listening: socket.socket | None = listen(path)
        self._talking: list[socket.socket] = []
        loop.listen(self._listening, self._welcome)

    def close(self) -> None:
        """Close all connections and remove the socket; may be called twice."""
        if self._listening is None:
            return
        for connection in list(self._talking):
            self._dismiss(connection)
        self._loop.forget(self._listening)
        stop_listening(self._listening)
        self._listening = None

    def _welcome(self) -> None:
        assert self._listening is not None
        with suppress(BlockingIOError):  # the client has gone again
            connection, _ = self._listening.accept()
            connection.setblocking(False)
            lines = Lines(self._answer)
            self._talking.append(connection)
            self._loop.listen(connection, lambda: self._hear(connection, lines))

    def _hear(self, connection: socket.socket, lines: Lines) -> None:
        try:
            data = connection.recv(LONGEST_LINE)
            if data:
                # A client that does not read its answers is disconnected: nothing is queued here.
                connection.sendall(lines.feed(data))
                return
        except (CommandError, OSError):
            pass
        self._dismiss(connection)

    def _dismiss(self, connection: socket.socket) -> None:
        self._loop.forget(connection)
        self._talking.remove(connection)
        connection.close()


class TypedLines:
    """Lines from standard input, answered on standard output."""

    def __init__(
        self,
        source: int,
        answer: Callable[[str], str],
        loop: RealTimeBoard,
        say: Callable[[str], None],
    ) -> None:
        """Read from ``source``, a file descriptor; 0 is standard input."""
        self._source = source
        self._lines = Lines(answer)
        self._loop = loop
        self._say = say
        loop.listen(source, self._hear)

    def _hear(self) -> None:
        try:
            data = os.read(self._source, LONGEST_LINE)
            answers = self._lines.feed(data) if data else b""
        except (CommandError, OSError):
            data = b""
        if not data:
            # The input has ended; the emulator goes on.
            self._loop.forget(self._source)
            return
        if answers:
            self._say(answers.decode().rstrip("\n"))
