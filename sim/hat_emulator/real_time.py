"""Lets an emulated board live by the clock on the wall, between a serial port and other inputs."""

from __future__ import annotations

import selectors
import time
from collections.abc import Callable
from typing import Any, Protocol

from sim.hat_emulator.pseudo_terminal import PseudoTerminal

TURN = 0.002
"""How often the board goes on when nothing comes in [s]; what leaves it is late by up to this."""

TICK = 0.001
"""The board's time goes on by whole ticks of this [s]."""

LONGEST_LAG = 0.1
"""After a stall this much is caught up [s]; for the board, the rest never was."""


class Board(Protocol):
    """A board with a clock of its own; ``EmulatedBoard`` is one."""

    @property
    def now(self) -> float:
        """Its time [s]."""
        ...

    def receive(self, data: bytes) -> None:
        """The program wrote this just now."""
        ...

    def advance(self, seconds: float) -> bytes:
        """Let time pass; returns what has left the wire."""
        ...


class RealTimeBoard:
    """The loop around a board; it has no thread, ``run`` is one's own."""

    def __init__(
        self,
        board: Board,
        terminal: PseudoTerminal,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self.board = board
        self.lost = 0.0
        """Time that stalls have cost [s]."""
        self._terminal = terminal
        self._clock = clock
        self._zero = clock() - board.now
        self._selector = selectors.SelectSelector()
        self._selector.register(terminal, selectors.EVENT_READ, self._hear)

    def wall(self, stamp: float) -> float:
        """From the board's time [s] to that of the clock on the wall [s]."""
        return self._zero + stamp

    def take(self, board: Board) -> None:
        """Go on with another board."""
        self.board = board
        self._zero = self._clock() - board.now

    def listen(self, source: Any, answer: Callable[[], None]) -> None:
        """Call ``answer`` whenever there is something to read from ``source``."""
        self._selector.register(source, selectors.EVENT_READ, answer)

    def forget(self, source: Any) -> None:
        """Listen to it no more."""
        self._selector.unregister(source)

    def run(self) -> None:
        """Go on from the board's present time until an exception ends it: Ctrl-C does."""
        due = self._clock()
        self._zero = due - self.board.now
        while True:
            due = max(due + TURN, self._clock())
            self.turn(max(0.0, due - self._clock()))

    def turn(self, wait: float) -> None:
        """Wait up to so long [s] for something to come in, and bring the board up to now."""
        ready = self._selector.select(wait)
        # What came in just now finds the board at its present time, not at that of the last turn.
        self._catch_up()
        for key, _ in ready:
            key.data()

    def close(self) -> None:
        """Let go of the inputs; they stay open."""
        self._selector.close()

    def _catch_up(self) -> None:
        behind = self._clock() - self._zero - self.board.now
        if behind > LONGEST_LAG:
            self.lost += behind - LONGEST_LAG
            self._zero += behind - LONGEST_LAG
            behind = LONGEST_LAG
        ticks = int(behind / TICK + 1e-6)
        if ticks > 0:
            self._terminal.write(self.board.advance(ticks * TICK))

    def _hear(self) -> None:
        self.board.receive(self._terminal.read())
