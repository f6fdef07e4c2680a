"""Interfaces of the devices at a board's ports, and of the motors that its drivers turn."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum
from typing import Protocol

from robot.errors import BrickPoseError

PORTS = 4
"""Number of ports of a board: A to D, on the wire 0 to 3."""

SAMPLE_PERIOD = 0.01
"""Time between two data messages of an active device [s]."""

CONNECT_SECONDS = 2.0
"""Usual time from plugging in until a device is usable [s]; real devices take up to 8 to 11 s."""


class ValueType(IntEnum):
    """Types of a mode's values on the wire; the numbers are those in the listing."""

    INT8 = 0
    INT16 = 1
    INT32 = 2
    FLOAT32 = 3

    @property
    def size(self) -> int:
        """Size of one value [bytes]."""
        return (1, 2, 4, 4)[self]


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


class Device(Protocol):
    """A device at a port. A passive device has no modes and sends nothing."""

    @property
    def type_id(self) -> int:
        """LEGO's type number of the device."""
        ...

    @property
    def passive(self) -> bool:
        """Whether the board identifies it by its resistors only; it then sends no data."""
        ...

    @property
    def modes(self) -> Sequence[Mode]:
        """The kinds of data that it can send, by mode number."""
        ...

    @property
    def combinations(self) -> Sequence[tuple[int, ...]]:
        """Modes that may be sent together."""
        ...

    @property
    def pid_defaults(self) -> tuple[tuple[int, ...], tuple[int, ...]]:
        """The device's defaults for a speed and a position controller; four words each."""
        ...

    connect_seconds: float
    """Time from plugging in until it is usable [s]."""

    responding: bool
    """False: it is plugged in but no longer sends data."""

    def description(self, port: int) -> str:
        """Return what ``list`` prints for it at a port, 0 to 3: lines that end in CR LF."""
        ...

    def power_up(self) -> None:
        """Switch its power on: it starts to count again from here."""
        ...

    def sample(self, current: float) -> bool:
        """Measure if a sample is due; call it every millisecond, or as often as wanted.

        Args:
            current: time of the board's clock [s], which never goes back.

        Returns:
            Whether there is a new message.
        """
        ...

    def read(self, mode: int) -> tuple[int | float, ...]:
        """Return the raw values of a mode in the newest message.

        Raises:
            DeviceError: there is no such mode.
        """
        ...


class DeviceError(BrickPoseError, ValueError):
    """A device does not exist, or not have what was asked for; the message says what is valid."""


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
