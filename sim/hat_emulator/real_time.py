"""Runs an emulated board in real time, and serves its serial port and other inputs."""

from __future__ import annotations

import selectors
import time
from collections.abc import Callable
from typing import Any, Protocol

from sim.hat_emulator.pseudo_terminal import PseudoTerminal

TURN = 0.002
"""Period of the board's progress without input [s]; its output is late by up to this time."""

TICK = 0.001
"""The board's time advances in whole ticks of this length [s]."""

LONGEST_LAG = 0.1
"""Longest time that is caught up after a stall [s]; the board skips the rest."""


class Board(Protocol):
    """A board with a clock of its own; ``EmulatedBoard`` is one."""

    @property
    def now(self) -> float:
        """Its time [s]."""
        ...

    def receive(self, data: bytes) -> None:
        """Take what the program has just written."""
        ...

    def advance(self, seconds: float) -> bytes:
        """Let time pass [s]; return the bytes that the board has sent."""
        ...


class RealTimeBoard:
    """Event loop of a board; it has no thread of its own, ``run`` uses the caller's."""

    def __init__(
        self,
        board: Board,
        terminal: PseudoTerminal,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self.board = board
        self.lost = 0.0
        """Time lost by stalls [s]."""
        self._terminal = terminal
        self._clock = clock
        self._zero = clock() - board.now
        self._selector = selectors.SelectSelector()
        self._selector.register(terminal, selectors.EVENT_READ, self._hear)

    def wall(self, stamp: float) -> float:
        """Convert a time of the board [s] to a time of the real clock [s]."""
        return self._zero + stamp

    def take(self, board: Board) -> None:
        """Continue with another board."""
        self.board = board
        self._zero = self._clock() - board.now

    def listen(self, source: Any, answer: Callable[[], None]) -> None:
        """Call ``answer`` whenever there is something to read from ``source``."""
        self._selector.register(source, selectors.EVENT_READ, answer)

    def forget(self, source: Any) -> None:
        """Stop listening to ``source``."""
        self._selector.unregister(source)

    def run(self) -> None:
        """Run from the board's present time until an exception ends it, as Ctrl-C does."""
        due = self._clock()
        self._zero = due - self.board.now
        while True:
            due = max(due + TURN, self._clock())
            self.turn(max(0.0, due - self._clock()))

    def turn(self, wait: float) -> None:
        """Wait up to ``wait`` [s] for input, and advance the board to the present time."""
        ready = self._selector.select(wait)
        # Advance first, so that the board gets the input at its present time.
        self._catch_up()
        for key, _ in ready:
            key.data()

    def close(self) -> None:
        """Stop listening to all inputs; they stay open."""
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
