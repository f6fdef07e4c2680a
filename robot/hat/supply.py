"""Watches the board's power: voltage, and the faults that the board tells of."""

from __future__ import annotations

import math

from robot.hat.protocol import commands

POLL_S = 0.1
"""How often the voltage is asked for [s]."""

USB_V = 5.5
"""Below this the board lives on what comes over USB, which does not reach the motors [V]."""

LOWEST_V, HIGHEST_V = 3.0, 20.0
"""Any supply that a board can tell of [V]."""

HYSTERESIS_V = 0.3
"""A supply that sagged under load is good again this much higher [V]."""

FAULT_S = 2.5
"""The board repeats a fault every second; without it for so long [s] the fault is over."""


class Supply:
    """Whether the motors may be driven, as far as power goes."""

    def __init__(self, low_v: float) -> None:
        self.volts: float | None = None
        """The last voltage told [V]."""
        self._low_v = low_v
        self._low = False
        self._low_before = False
        self._asked = -math.inf
        self._faults: dict[str, float] = {}
        """When a fault was last told [s]."""

    def forget(self) -> None:
        """The board begins anew."""
        self.volts = None
        self._low = self._low_before = False
        self._asked = -math.inf
        self._faults.clear()

    def ask(self, current: float) -> bytes:
        """The question for the voltage, when it is due."""
        if current - self._asked < POLL_S:
            return b""
        self._asked = current
        return commands.supply()

    def told(self, volts: float) -> None:
        """A voltage came [V]. Low counts from the second time on: a start takes it down briefly.

        What the board cannot live on was garbled on the way.
        """
        if not LOWEST_V <= volts <= HIGHEST_V:
            return
        self.volts = volts
        limit = self._low_v + (HYSTERESIS_V if self._low else 0.0)
        low = volts < limit
        self._low = low and (self._low or self._low_before)
        self._low_before = low

    def fault(self, what: str, current: float) -> bytes:
        """The board told of a fault, "motor" or "port"; returns what clears its latch."""
        self._faults[what] = current
        return commands.clear_faults()

    def complaints(self, current: float) -> list[str]:
        """Why the motors may not be driven, with the cure."""
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

    def _recent(self, what: str, current: float) -> bool:
        return current - self._faults.get(what, -math.inf) < FAULT_S
