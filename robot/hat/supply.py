"""Monitors the board's supply: its voltage, and the faults that the board reports."""

from __future__ import annotations

import math

from robot.hat.protocol import commands

POLL_S = 0.1
"""Time between two requests for the voltage [s]."""

USB_V = 5.5
"""Below this voltage the board runs on power from USB, which does not reach the motors [V]."""

LOWEST_V, HIGHEST_V = 3.0, 20.0
"""Lowest and highest voltage that a board can report [V]."""

HYSTERESIS_V = 0.3
"""A supply that was too low is good again this much above the limit [V]."""

FAULT_S = 2.5
"""A fault is over if the board does not report it for this time [s]; it repeats it every second."""


class Supply:
    """Decides whether the power supply allows the motors to be driven."""

    def __init__(self, low_v: float) -> None:
        self.volts: float | None = None
        """The last reported voltage [V]."""
        self._low_v = low_v
        self._low = False
        self._low_before = False
        self._asked = -math.inf
        self._faults: dict[str, float] = {}
        """When each fault was last reported [s]."""

    def forget(self) -> None:
        """Forget everything, because the board starts again."""
        self.volts = None
        self._low = self._low_before = False
        self._asked = -math.inf
        self._faults.clear()

    def ask(self, current: float) -> bytes:
        """Return the request for the voltage, if it is due."""
        if current - self._asked < POLL_S:
            return b""
        self._asked = current
        return commands.supply()

    def take_voltage(self, volts: float) -> None:
        """Take a reported voltage [V].

        A low voltage counts from the second time on, because a start lowers it briefly. A voltage
        on which the board cannot run was garbled on the way and is ignored.
        """
        if not LOWEST_V <= volts <= HIGHEST_V:
            return
        self.volts = volts
        limit = self._low_v + (HYSTERESIS_V if self._low else 0.0)
        low = volts < limit
        self._low = low and (self._low or self._low_before)
        self._low_before = low

    def fault(self, kind: str, current: float) -> bytes:
        """Take a fault that the board reported, "motor" or "port"; return what clears its latch."""
        self._faults[kind] = current
        return commands.clear_faults()

    def complaints(self, current: float) -> list[str]:
        """Return why the motors may not be driven, with the cure."""
        result = []
        if self._recent("motor", current):
            result.append(
                "The Build HAT reports a motor power fault: a motor is blocked or its cable is "
                "damaged. Free the wheels, or unplug motor after motor to find it."
            )
        if self._recent("port", current):
            result.append(
                "The Build HAT reports a port power fault: something on a port takes too much "
                "current. Unplug one after the other to find it."
            )
        if self._low and self.volts is not None:
            result.append(
                "The motors have no supply, the board lives on USB: connect the battery."
                if self.volts < USB_V
                else "The battery is low: charge it."
            )
        return result

    def _recent(self, kind: str, current: float) -> bool:
        return current - self._faults.get(kind, -math.inf) < FAULT_S
