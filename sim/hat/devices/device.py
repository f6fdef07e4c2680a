"""What the devices at a board's ports send, and the motors that its drivers turn."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum
from typing import Protocol

PORTS = 4
"""Number of ports of a board: A to D, on the wire 0 to 3."""

SAMPLE_PERIOD = 0.01
"""Time between two data messages of a device [s]."""

CONNECT_SECONDS = 2.0
"""Usual time from plugging in until a device is usable [s]; real devices take up to 8 to 11 s."""


class ValueType(IntEnum):
    """Types of a mode's values on the wire; the numbers are those in the listing."""

    INT8 = 0
    INT16 = 1
    INT32 = 2

    @property
    def size(self) -> int:
        """Size of one value [bytes]."""
        return (1, 2, 4)[self]


@dataclass(frozen=True, slots=True)
class Mode:
    """One kind of data that a device can send."""

    name: str
    """Name of the mode; it may contain a blank."""
    unit: str
    """Unit of the values; it may be empty."""
    type: ValueType
    count: int
    """Number of values in one message."""
    chars: int
    """Number of characters that a display needs for one value."""
    dp: int
    """Number of digits after the decimal point."""
    raw: int
    """Largest raw value; the listing shows every smallest value as 0."""
    pct: int
    """Largest value in percent."""
    si: int
    """Largest value in ``unit``."""


class DeviceError(ValueError):
    """A device does not have what was asked for."""


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
