"""Setpoint of a port: constant, a single pulse, or a single ramp."""

from __future__ import annotations

from enum import Enum

from sim.hat.firmware.variables import clamped, single

TICK = 0.01
"""Time between two setpoints [s]."""

SHORTEST = 2 * TICK
"""Shortest pulse or ramp [s]."""


class Shape(Enum):
    """Shape of a setpoint over time; the names are those of the command language."""

    PULSE = "pulse"
    RAMP = "ramp"


class Waveform:
    """Setpoint over time, advanced every 10 ms.

    All sums are in single precision, so the length of a long pulse is not exact. The time goes on
    while the setpoint is constant.
    """

    __slots__ = ("_end", "_length", "_shape", "_start", "_time", "setpoint")

    def __init__(self) -> None:
        self.setpoint = 0.0
        self._time = 0.0
        """Time since the start of the shape, or of the last full second [s]."""
        self.hold(0.0)

    def hold(self, value: float) -> None:
        """Set a constant."""
        self._shape: Shape | None = None
        self._start = self._end = value
        self._length = 1.0

    def begin(self, shape: Shape, start: float, end: float, length: float) -> None:
        """Begin a pulse at ``start``, or a ramp from ``start`` to ``end``; length in seconds."""
        self._shape = shape
        self._start, self._end = start, end
        self._length = single(clamped(length, SHORTEST, 1e30))
        self._time = 0.0

    def advance(self) -> Shape | None:
        """Advance by 10 ms to a new ``setpoint``.

        Returns:
            The pulse or ramp that has just ended; its end is held from then on.
        """
        time = single(self._time + TICK)
        ended = None
        if time >= self._length:
            time = single(time - self._length)
            ended = self._shape
            if ended is not None:
                self.hold(self._end)
        if time >= self._length:
            time = 0.0
        self._time = time
        self.setpoint = self._start
        if self._shape is Shape.RAMP:
            share = single(time / self._length)
            self.setpoint = single(self._start + single(single(self._end - self._start) * share))
        return ended
