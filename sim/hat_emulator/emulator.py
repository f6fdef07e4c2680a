"""The emulated board with its devices, its surroundings and the loop that runs it in real time."""

from __future__ import annotations

import selectors
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from robot.description.wiring import PORTS
from sim.hat.emulated_board import EmulatedBoard
from sim.hat.lego_motor import LegoMotor
from sim.hat.motor_figures import MotorFigures
from sim.hat.processor import TICK, VERSION
from sim.hat_emulator.pseudo_terminal import PseudoTerminal
from sim.hat_emulator.surroundings import Surroundings

TURN = 0.002
"""Period of the board's progress without input [s]; its output is late by up to this time."""

LONGEST_LAG = 0.1
"""Longest time that is caught up after a stall [s]; the board skips the rest."""


class RealTimeBoard:
    """Event loop of a board; it has no thread of its own, ``run`` uses the caller's."""

    def __init__(
        self,
        board: EmulatedBoard,
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

    def take(self, board: EmulatedBoard) -> None:
        """Continue with another board."""
        self.board = board
        self._zero = self._clock() - board.now

    def listen(self, source: Any, answer: Callable[[], None]) -> None:
        """Call ``answer`` whenever there is something to read from ``source``."""
        self._selector.register(source, selectors.EVENT_READ, answer)

    def forget(self, source: Any) -> None:
        """Stop listening to ``source``."""
        self._selector.unregister(source)

    def run(self, until: Callable[[], bool]) -> None:
        """Run from the board's present time until a condition holds."""
        due = self._clock()
        self._zero = due - self.board.now
        while not until():
            current = self._clock()
            # Turns that end early, for there is input, must not add up to a long wait.
            due = min(max(due + TURN, current), current + TURN)
            self.turn(due - current)

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


GREETING = 0.05
"""How long a bootloader is deaf after its start, while it greets [s]; the emulator skips this."""

LARGEST_DRIFT = 0.01
"""Largest drift of the motors' clocks against the board's, as a share. It was not measured. But two
clocks are never equal, so the board's reports contain samples of every age."""


@dataclass(frozen=True)
class InitialState:
    """State in which the emulator starts."""

    warm: bool = True
    """True: the firmware runs and knows the devices; False: the bootloader waits for an image."""
    version: int = VERSION
    """Version of the firmware that runs."""
    seed: int = 0
    """Seed of the motors' marks, sampling times and clock drifts, and of garbled bytes."""


class Emulator:
    """Emulated Build HAT that runs in real time."""

    def __init__(
        self,
        surroundings: Surroundings,
        motors: Mapping[int, MotorFigures],
        terminal: PseudoTerminal,
        beginning: InitialState | None = None,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """Switch it on, with motors plugged in by port, 0 to 3."""
        self.surroundings = surroundings
        self._beginning = beginning or InitialState()
        self._terminal = terminal
        rng = np.random.default_rng(self._beginning.seed)
        self._marks = rng.uniform(-180, 180, len(PORTS)).tolist()
        self._phases = rng.uniform(0, 0.01, len(PORTS)).tolist()
        self._drifts = rng.uniform(-LARGEST_DRIFT, LARGEST_DRIFT, len(PORTS)).tolist()
        self._started = 0.0
        devices = {port: self.motor(port, figures) for port, figures in motors.items()}
        self.board = self._new_board(devices, self._beginning.version, self._beginning.warm)
        if not self._beginning.warm:
            self.board.advance(GREETING)
        self.loop = RealTimeBoard(self.board, terminal, clock)
        self.unplugged: dict[int, LegoMotor] = {}
        """The device that was unplugged last, by port."""

    def motor(self, port: int, figures: MotorFigures) -> LegoMotor:
        """Return a motor on the shaft at a port; its mark is at another angle for each port."""
        plant = self.surroundings.plants.plant(port)
        return LegoMotor(
            figures.type_id,
            plant,
            mark=self._marks[port],
            phase=self._phases[port],
            drift=self._drifts[port],
        )

    def wall(self, stamp: float) -> float:
        """Convert a time of the surroundings [s] to a time of the real clock [s]."""
        return self.loop.wall(stamp - self._started)

    def restart(self, version: int) -> None:
        """Replace the board: the same devices, but another version of the firmware runs."""
        self.board.reset()
        self._started += self.board.now
        self.board = self._new_board(dict(self.board.devices), version, warm=True)
        self.loop.take(self.board)

    def _new_board(
        self, devices: Mapping[int, LegoMotor], version: int, warm: bool
    ) -> EmulatedBoard:
        plants, seed = self.surroundings.plants, self._beginning.seed
        return EmulatedBoard(plants, devices, warm=warm, version=version, seed=seed)
