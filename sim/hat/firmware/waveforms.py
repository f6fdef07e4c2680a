"""Setpoint of a port: constant, periodic, a single pulse or ramp, or following a variable."""

from __future__ import annotations

import math
from enum import Enum

from sim.hat.firmware.single import clamped, single
from sim.hat.firmware.variables import Modes, Variable

TICK = 0.01
"""Time between two setpoints [s]."""

SHORTEST = 2 * TICK
"""Shortest period, length or duration [s]."""

SINE = tuple(single(round(math.sin(2 * math.pi * step / 256), 5)) for step in range(256))
"""One period of a sine; the firmware's table has five decimals."""


class Shape(Enum):
    """Shape of a setpoint over time; the names are those of the command language."""

    SQUARE = "square"
    SINE = "sine"
    TRIANGLE = "triangle"
    PULSE = "pulse"
    RAMP = "ramp"
    FOLLOWING = "var"


class Waveform:
    """Setpoint over time, advanced every 10 ms.

    All sums are in single precision, so the length of a long pulse is not exact.
    """

    __slots__ = ("_follow", "high", "low", "period", "phase", "progress", "setpoint", "shape")

    def __init__(self) -> None:
        self.setpoint = 0.0
        self.progress = 0.0
        """Time since the start of the period [s], or the value of the followed variable."""
        self._follow = Variable()
        self.hold(0.0)

    def hold(self, value: float) -> None:
        """Set a constant; the time within the period is not reset."""
        self.shape = Shape.SQUARE
        self.low = self.high = value
        self.period = 1.0
        self.phase = 0.0

    def begin(self, shape: Shape, low: float, high: float, period: float, phase: float) -> None:
        """Start a shape at its beginning; period [s] and phase (0..1) are clipped to their limits.

        For ``FOLLOWING``, period and phase are slope and offset, without limits.
        """
        if shape is not Shape.FOLLOWING:
            period = single(clamped(period, SHORTEST, 1e30))
            phase = clamped(phase, 0, 1)
        self.shape = shape
        self.low, self.high, self.period, self.phase = low, high, period, phase
        self.progress = 0.0

    def follow(self, variable: Variable) -> None:
        """Set the variable that a ``FOLLOWING`` setpoint follows."""
        self._follow = variable

    def advance(self, modes: Modes) -> Shape | None:
        """Advance by 10 ms to a new ``setpoint``.

        Args:
            modes: data of all ports, with the variable to follow.

        Returns:
            The pulse or ramp that has just ended; ``high`` is held from then on.
        """
        if self.shape is Shape.FOLLOWING:
            self._look(modes)
            return None
        time = single(self.progress + TICK)
        ended = None
        if time >= self.period:
            time = single(time - self.period)
            if self.shape in (Shape.PULSE, Shape.RAMP):
                ended = self.shape
                self.hold(self.high)
        if time >= self.period:
            time = 0.0
        self.progress = time
        part = single(single(time / self.period) + self.phase)
        self.setpoint = self._value(single(part - 1) if part >= 1 else part)
        return ended

    def _look(self, modes: Modes) -> None:
        value = self._follow.read(modes, False, self.progress)
        if value is not None:
            self.progress = value
        mapped = single(single(self.progress - self.phase) * self.period)
        self.setpoint = clamped(mapped, self.low, self.high)

    def _value(self, part: float) -> float:
        """Return the value of the shape at a share of its period, 0..1."""
        low, high = self.low, self.high
        if self.shape is Shape.SQUARE:
            return high if part >= 0.5 else low
        if self.shape is Shape.PULSE:
            return low
        span = single(high - low)
        if self.shape is Shape.SINE:
            swing = single(SINE[int(part * 256 + 0.5) % 256] + 1)
            return single(low + single(span * swing) * 0.5)
        if self.shape is Shape.TRIANGLE:
            part = single(1 - part) if part >= 0.5 else part
            return single(low + single(single(span * part) * 2))
        return single(low + single(span * part))
