"""Upload to the bootloader: STX, exactly the announced number of bytes, ETX."""

from __future__ import annotations

from enum import Enum, auto

STX, ETX = 0x02, 0x03

TIME_OUT = 1.0
"""The upload fails after waiting longer than this for the next byte [s]."""


class Stage(Enum):
    """State of an upload: what it waits for, or how it ended."""

    START = auto()
    DATA = auto()
    END = auto()
    COMPLETE = auto()
    TIMED_OUT = auto()


class Upload:
    """One upload; ``data`` is complete when ``stage`` is COMPLETE.

    Bytes before STX, and between the last byte of data and ETX, are skipped; they do not extend
    the time-out.
    """

    def __init__(self, length: int) -> None:
        self.stage = Stage.START
        self.data = bytearray()
        self._length = length
        self._waited = 0.0

    def receive(self, byte: int) -> None:
        """Take the next byte from the line."""
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
        # The small term allows for the rounding of added milliseconds.
        if self._waited > TIME_OUT + 1e-6:
            self.stage = Stage.TIMED_OUT

    def _go_on(self, stage: Stage) -> None:
        self.stage = stage
        self._waited = 0.0
