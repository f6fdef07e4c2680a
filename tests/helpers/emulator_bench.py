"""An emulator on a bench: on a clock that the test moves, with a program at its port."""

from __future__ import annotations

import os

from sim.hat.motor_figures import figures_named
from sim.hat_emulator.control import Control
from sim.hat_emulator.emulator import Emulator, InitialState
from sim.hat_emulator.pseudo_terminal import PseudoTerminal
from sim.hat_emulator.surroundings import Surroundings, Table

MEDIUM = figures_named("medium")
A, B, C, D = range(4)
START = 50.0


class Bench:
    """An emulator on a clock that the test moves, with a program at its port."""

    def __init__(
        self, around: Surroundings | None = None, beginning: InitialState | None = None
    ) -> None:
        self.now = START
        self.around = around or Table({A: MEDIUM, B: MEDIUM})
        self.terminal = PseudoTerminal()
        motors = {A: MEDIUM, B: MEDIUM}
        self.emulator = Emulator(self.around, motors, self.terminal, beginning, self.clock)
        self.control = Control(self.emulator)
        self.port = os.open(self.terminal.device, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)

    def clock(self) -> float:
        return self.now

    def ask(self, line: str) -> str:
        return self.control.answer(line)

    def send(self, text: str) -> None:
        os.write(self.port, text.encode())

    def run(self, seconds: float) -> str:
        """What the board says meanwhile."""
        heard = b""
        for _ in range(round(seconds / 0.002)):
            self.emulator.loop.turn(0)
            self.now += 0.002
            try:
                heard += os.read(self.port, 65536)
            except BlockingIOError:
                continue
        return heard.decode("utf-8", "replace")

    def say(self, text: str, seconds: float = 0.1) -> str:
        self.send(text)
        return self.run(seconds)

    def close(self) -> None:
        os.close(self.port)
        self.emulator.loop.close()
        self.terminal.close()
        self.around.close()
