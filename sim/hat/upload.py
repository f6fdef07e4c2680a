"""How the bootloader takes bytes that are no command: STX, exactly so many of them, ETX."""

from __future__ import annotations

from enum import Enum, auto

STX, ETX = 0x02, 0x03

TIME_OUT = 1.0
"""How long a byte that is due may stay away [s]; more than this is too long."""


class Stage(Enum):
    """What an upload waits for."""

    START = auto()
    DATA = auto()
    END = auto()
    COMPLETE = auto()
    TIMED_OUT = auto()


class Upload:
    """One payload under way; ``data`` is whole when ``stage`` is COMPLETE.

    Anything before STX is skipped, and so is anything between the last byte and ETX; neither
    keeps the time from running out.
    """

    def __init__(self, length: int) -> None:
        self.stage = Stage.START
        self.data = bytearray()
        self._length = length
        self._waited = 0.0

    def receive(self, byte: int) -> None:
        """The next byte from the line."""
        if self.stage is Stage.START and byte == STX:
            self._go_on(Stage.DATA if self._length else Stage.END)
        elif self.stage is Stage.DATA:
            self.data.append(byte)
            self._go_on(Stage.DATA if len(self.data) < self._length else Stage.END)
        elif self.stage is Stage.END and byte == ETX:
            self._go_on(Stage.COMPLETE)

    def tick(self, seconds: float) -> None:
        """Let time pass [s]."""
        self._waited += seconds
        # Ticks of a millisecond add up to a hair more or less than the whole.
        if self._waited > TIME_OUT + 1e-6:
            self.stage = Stage.TIMED_OUT

    def _go_on(self, stage: Stage) -> None:
        self.stage = stage
        self._waited = 0.0
