"""Controller of a port: it computes the drive from the setpoint, directly or by PID."""

from __future__ import annotations

from enum import Enum

from sim.hat.firmware.variables import Modes, Variable, clamped, single

TICK = 0.01
"""Time between two runs [s]."""


class Control(Enum):
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
        self.control = Control.DIRECT
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
        if self.control is Control.DIRECT:
            return setpoint
        value = self.variable.read(modes, self.control is Control.RATE, self._value)
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
