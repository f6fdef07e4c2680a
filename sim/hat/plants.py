"""The motors that a board's drivers turn; those that turn freely, without a robot.

A free motor is a first-order model with friction, brake and coasting.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Protocol

from sim.hat.motor_figures import RAIL_V, SUPPLY_V, DeviceError, MotorFigures, figures_named

PORTS = 4
"""Number of ports of a board: A to D, on the wire 0 to 3."""


class Plant(Protocol):
    """The motor that one port's driver turns; angles are in degrees, which a motor counts."""

    @property
    def angle(self) -> float:
        """Angle of the shaft [deg], never wrapped; clockwise is positive, as POS counts."""
        ...

    @property
    def speed(self) -> float:
        """Angular velocity of the shaft [deg/s]."""
        ...

    def drive(self, duty: float | None) -> None:
        """Set the share of its voltage that the driver puts out, -1..1.

        0 brakes, because the driver then shorts the motor. None disconnects the motor: it coasts.
        """
        ...


class Plants(Protocol):
    """The motors at all ports; time passes only in ``step``."""

    supply_v: float
    """Supply voltage of the board [V]; the board keeps it up to date."""

    def plant(self, port: int) -> Plant:
        """Return the motor at a port, 0 to 3, even if no device is plugged in there."""
        ...

    def step(self, seconds: float) -> None:
        """Let time [s] pass for all of them together."""
        ...


class FreeMotor:
    """DC motor on a rigid shaft.

    While its driver is on, ``tau dw/dt = gain V - w - s (load + friction sign(w))``, where s is the
    slope of the torque-speed line; V = 0 is the brake of a shorted motor. While it coasts, the
    terms of the current, ``gain V - w``, are missing. A shaft at rest stays at rest until the
    torque on it exceeds the breakaway torque. Steps are solved exactly, also when the shaft turns
    back.
    """

    def __init__(self, figures: MotorFigures) -> None:
        self.figures = figures
        self.angle = 0.0
        self.speed = 0.0
        self.stalled = False
        """Whether something blocks the shaft."""
        self._tau = figures.time_constant
        self._gain = figures.gain * RAIL_V / SUPPLY_V
        self._friction = figures.friction * figures.speed_per_torque
        self._breakaway = figures.breakaway * figures.speed_per_torque
        self._load = 0.0
        self._duty: float | None = None
        self._pull = 0.0
        self._supply_v = SUPPLY_V

    @property
    def duty(self) -> float | None:
        """Output of the driver, -1..1; None: it is off."""
        return self._duty

    def drive(self, duty: float | None) -> None:
        """Set the share of its voltage that the driver puts out; see ``Plant``.

        Raises:
            DeviceError: the duty is outside -1..1, or not a number.
        """
        if duty is not None and not -1 <= duty <= 1:
            raise DeviceError(f"duty is {duty}; valid is -1 to 1, or None to coast")
        self._duty = duty
        self._pull = self._gain * self._supply_v * (duty or 0.0)

    @property
    def load(self) -> float:
        """Torque [N m] that turns the shaft anticlockwise, as a hanging weight does."""
        return self._load / self.figures.speed_per_torque

    @load.setter
    def load(self, torque: float) -> None:
        if not math.isfinite(torque):
            raise DeviceError(f"load is {torque}; valid is a torque [N m]")
        self._load = torque * self.figures.speed_per_torque

    @property
    def supply_v(self) -> float:
        """Supply voltage of the board [V]."""
        return self._supply_v

    @supply_v.setter
    def supply_v(self, volts: float) -> None:
        self._supply_v = volts
        self.drive(self._duty)

    def step(self, seconds: float) -> None:
        """Let time pass [s]."""
        if self.stalled:
            self.speed = 0.0
            return
        left = seconds
        # Each pass ends the step, or stops the shaft, which may then turn the other way.
        while left > 0:
            direction = self._direction()
            if direction == 0:
                return
            push = self._pull - self._load - direction * self._friction
            left = self._coast(push, left) if self._duty is None else self._turn(push, left)

    def _direction(self) -> int:
        """Return the sign of its speed or, at rest, of the coming motion; 0: it stays at rest."""
        if self.speed != 0:
            return 1 if self.speed > 0 else -1
        push = self._pull - self._load
        if abs(push) <= self._breakaway:
            return 0
        return 1 if push > 0 else -1

    def _turn(self, target: float, seconds: float) -> float:
        """Approach a speed [deg/s] until the time is over or it stops; return the time left."""
        start = self.speed
        fade = math.exp(-seconds / self._tau)
        end = target + (start - target) * fade
        left = 0.0
        if start * end < 0:
            used = self._tau * math.log((target - start) / target)
            left, end = max(seconds - used, 0.0), 0.0
        # From the integrated equation of motion: angle = target * time - tau * (change of speed).
        self.angle += target * (seconds - left) - self._tau * (end - start)
        self.speed = end
        return left

    def _coast(self, push: float, seconds: float) -> float:
        """Change speed evenly until the time is over or it stops; return the time left."""
        start = self.speed
        end = start + push / self._tau * seconds
        left = 0.0
        if start * end < 0:
            left, end = max(seconds + start * self._tau / push, 0.0), 0.0
        self.angle += (start + end) / 2 * (seconds - left)
        self.speed = end
        return left


class FreeMotors:
    """Free motors at the four ports."""

    def __init__(self, figures: Mapping[int, MotorFigures] | None = None) -> None:
        """Put motors at the ports, with ``figures`` by port; the default is a medium motor.

        Raises:
            DeviceError: a port outside 0..3.
        """
        figures = {} if figures is None else figures
        for port in figures:
            _check(port)
        self._motors = tuple(
            FreeMotor(figures.get(port, figures_named("medium"))) for port in range(PORTS)
        )

    @property
    def supply_v(self) -> float:
        """Supply voltage of the board [V]."""
        return self._motors[0].supply_v

    @supply_v.setter
    def supply_v(self, volts: float) -> None:
        for motor in self._motors:
            motor.supply_v = volts

    def plant(self, port: int) -> FreeMotor:
        """Return the motor at a port.

        Raises:
            DeviceError: a port outside 0..3.
        """
        _check(port)
        return self._motors[port]

    def step(self, seconds: float) -> None:
        """Let time pass [s] for all of them."""
        for motor in self._motors:
            motor.step(seconds)


def _check(port: int) -> None:
    if not 0 <= port < PORTS:
        raise DeviceError(f"port is {port}; valid are 0 to {PORTS - 1}")
