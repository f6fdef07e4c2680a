"""Supply voltage and fault lines of the board, as its firmware sees them."""

from __future__ import annotations

from dataclasses import dataclass

from sim.hat.plants import PORTS

CONVERTER = 4095
"""Largest value of the analogue converter, which measures 0 to 3.3 V after a divider by 5.7."""

DEBOUNCE = 10
"""A fault is reported if it lasts longer than this [ms]."""

REPEAT = 1000
"""Time until a lasting fault is reported again [ms]; for a motor fault, ``DEBOUNCE`` more."""


@dataclass(slots=True)
class Power:
    """Electrical state of the board; a restart of the firmware keeps it."""

    supply_v: float = 8.0
    motor_fault: bool = False
    """Whether the common fault line of the motor drivers is low."""
    port_fault: bool = False
    """Whether the 3.3 V supply of the devices is overloaded."""

    @property
    def millivolts(self) -> int:
        """The supply as measured by the converter [mV], in steps of 4.6 mV."""
        raw = round(self.supply_v / 5.7 / 3.3 * (CONVERTER + 1))
        raw = max(0, min(CONVERTER, raw))
        return raw * 57 // 10 * 3300 // 4096


def supply_text(millivolts: int) -> str:
    """Return what ``vin`` prints [V]: two decimals, rounded half up in fixed point."""
    fixed = (millivolts << 16) // 1000 + 655 // 2
    return f"{fixed >> 16}.{((fixed & 0xFFFF) * 100) >> 16:02d} V\r\n"


class FaultWatch:
    """Reports faults that last, and repeats the reports while they last."""

    __slots__ = ("_motor", "_port", "_power")

    def __init__(self, power: Power) -> None:
        self._power = power
        self._motor = 0
        self._port = 0

    def passed(self, milliseconds: int) -> str:
        """Let time pass; return the text to print."""
        return self._port_text(milliseconds) + self._motor_text(milliseconds)

    def _port_text(self, milliseconds: int) -> str:
        self._port = self._port + milliseconds if self._power.port_fault else 0
        if DEBOUNCE < self._port < REPEAT:
            self._port = 2 * REPEAT
        if self._port < 2 * REPEAT:
            return ""
        self._port -= REPEAT
        return "Port power fault\r\n"

    def _motor_text(self, milliseconds: int) -> str:
        self._motor += milliseconds
        if self._motor >= 0 and not self._power.motor_fault:
            self._motor = 0
        if self._motor <= DEBOUNCE:
            return ""
        self._motor = -REPEAT
        flags = "".join(f"   {port}  BA 2C 8A\r\n" for port in range(PORTS))
        return f"Motor power fault\r\n Port 4D 4E 4F\r\n{flags}"
