"""The emulated board with its devices, its surroundings and the loop that runs it in real time."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from robot.description.wiring import PORTS
from sim.hat.devices.lego_motor import LegoMotor
from sim.hat.devices.motor_figures import MotorFigures
from sim.hat.emulated_board import EmulatedBoard
from sim.hat.processor import VERSION
from sim.hat_emulator.pseudo_terminal import PseudoTerminal
from sim.hat_emulator.real_time import RealTimeBoard
from sim.hat_emulator.surroundings import Surroundings

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
