"""Drive of a port: its setpoint, its controller, and the pulses of its H-bridge."""

from __future__ import annotations

import math
from enum import Enum

from sim.hat.firmware.variables import Modes, Variable, clamped, single

TICK = 0.01
"""Time between two setpoints [s]."""

SHORTEST = 2 * TICK
"""Shortest pulse or ramp [s]."""
ONE = 65536
"""Full drive in the firmware's fixed point."""
STEPS = 255
"""Full drive in steps of the driver chip."""
FIRST_LIMIT = 6554
"""Largest drive of a port until it is set: a tenth of full drive."""


class WaveShape(Enum):
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
        self._shape: WaveShape | None = None
        self._start = self._end = value
        self._length = 1.0

    def begin(self, shape: WaveShape, start: float, end: float, length: float) -> None:
        """Begin a pulse at ``start``, or a ramp from ``start`` to ``end``; length in seconds."""
        self._shape = shape
        self._start, self._end = start, end
        self._length = single(clamped(length, SHORTEST, 1e30))
        self._time = 0.0

    def advance(self) -> WaveShape | None:
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
        if self._shape is WaveShape.RAMP:
            share = single(time / self._length)
            self.setpoint = single(self._start + single(single(self._end - self._start) * share))
        return ended


class ControlMode(Enum):
    """Meaning of the setpoint."""

    DIRECT = 0
    """The drive itself."""
    VALUE = 1
    """The wanted value of the watched variable."""
    RATE = 2
    """The wanted rate of change of the watched variable [1/s]."""


class Controller:
    """PID on ``e = value - setpoint`` in single precision; no command resets its integral.

    ``drive = -(Kp e + Ki I + Kd D)``, with ``I += e dt`` within +-windup and ``D = de / dt``.
    """

    __slots__ = (
        "_error",
        "_integral",
        "_value",
        "control",
        "dead_zone",
        "derivative_gain",
        "integral_gain",
        "proportional_gain",
        "variable",
        "windup",
    )

    def __init__(self) -> None:
        self.control = ControlMode.DIRECT
        self.variable = Variable()
        self.proportional_gain = self.integral_gain = self.derivative_gain = 0.0
        self.windup = 0.0
        self.dead_zone = 0.0
        self._value = self._integral = self._error = 0.0

    def drive(self, modes: Modes, setpoint: float) -> float | None:
        """Return the drive, without limits; None: no data of the variable, keep the last drive.

        Args:
            modes: data of all ports.
            setpoint: the wanted drive, value or rate.
        """
        if self.control is ControlMode.DIRECT:
            return setpoint
        value = self.variable.read(modes, self.control is ControlMode.RATE, self._value)
        if value is None:
            return None
        self._value = value
        return self._run(value, setpoint)

    def _run(self, value: float, setpoint: float) -> float:
        error = single(value - setpoint)
        if abs(error) < self.dead_zone:
            error = 0.0
        derivative = single(single(error - self._error) / TICK)
        self._error = error
        integral = single(self._integral + error * TICK)
        self._integral = integral = clamped(integral, -self.windup, self.windup)
        proportional = single(error * self.proportional_gain)
        both = single(proportional + single(integral * self.integral_gain))
        return -single(both + single(derivative * self.derivative_gain))


def fixed_point(part: float) -> int:
    """Return a share of full drive, clipped to 0..1, in fixed point."""
    return int(clamped(part, 0, 1) * ONE + 0.5)


class HBridge:
    """Motor driver; it makes small drives from the right share of 10 ms slots at the threshold."""

    __slots__ = ("_owed", "least", "limit", "steps", "threshold")

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Reset as after a start or a disconnection: limit a tenth, no threshold, braking."""
        self.limit = FIRST_LIMIT
        self.threshold = 0
        """Smaller drives are made of slots."""
        self.least = 0
        """Smaller drives become 0."""
        self._owed = 0
        self.steps: int | None = 0
        """Output of the chip, -255..255; None: it is switched off."""

    @property
    def duty(self) -> float | None:
        """Output, -1..1; 0 brakes, None coasts."""
        return None if self.steps is None else self.steps / STEPS

    def coast(self) -> None:
        """Let the motor coast."""
        self.steps = None

    def drive(self, wanted: float) -> None:
        """Put out a drive, clipped to -1..1 and then to ``limit``; called every 10 ms."""
        doubled = 0 if math.isnan(wanted) else int(clamped(wanted, -1, 1) * 2 * ONE)
        demand = int((doubled + 1) / 2)
        if abs(demand) < self.least:
            demand = 0
        if abs(demand) < self.threshold:
            demand = self._slot(demand)
        demand = max(-self.limit, min(self.limit, demand))
        # The firmware's shift rounds the chip's steps down, also below zero.
        self.steps = (demand * STEPS + STEPS // 2) >> 16

    def _slot(self, demand: int) -> int:
        self._owed += demand
        if self._owed >= self.threshold:
            slot = self.threshold
        elif self._owed <= -self.threshold:
            slot = -self.threshold
        else:
            slot = 0
        self._owed -= slot
        return slot
