"""What the board's firmware sees of a device on one of its ports, and of what its driver turns."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum
from typing import Protocol

PORTS = 4
"""That a board has, A to D; on the wire 0 to 3."""

SAMPLE_PERIOD = 0.01
"""Time between two data messages of an active device [s]."""

CONNECT_SECONDS = 2.0
"""Usual time from plugging in until the device is usable [s]; real ones take up to 8 to 11 s."""


class ValueType(IntEnum):
    """How a mode's values travel on the wire, by the number that the listing shows."""

    INT8 = 0
    INT16 = 1
    INT32 = 2
    FLOAT32 = 3

    @property
    def size(self) -> int:
        """Bytes of one value."""
        return (1, 2, 4, 4)[self]


@dataclass(frozen=True, slots=True)
class Mode:
    """One kind of data that a device can send."""

    name: str
    """May have a blank in it."""
    unit: str
    """May be empty."""
    type: ValueType
    count: int
    """Numbers in one message."""
    chars: int
    """Characters that a display needs for one number."""
    dp: int
    """Digits after the point."""
    raw: int
    """Largest value in the device's own numbers; the listing shows every smallest one as 0."""
    pct: int
    """Largest value in percent."""
    si: int
    """Largest value in ``unit``."""


class Device(Protocol):
    """Something plugged into a port. A passive device has no modes and sends nothing."""

    @property
    def type_id(self) -> int:
        """LEGO's number of the kind of device."""
        ...

    @property
    def passive(self) -> bool:
        """Whether it is known by its resistors only and cannot talk."""
        ...

    @property
    def modes(self) -> Sequence[Mode]:
        """What it can send, by mode number."""
        ...

    @property
    def combinations(self) -> Sequence[tuple[int, ...]]:
        """Modes that may be sent together."""
        ...

    @property
    def pid_defaults(self) -> tuple[tuple[int, ...], tuple[int, ...]]:
        """The device's own proposals for a speed and a position controller; four words each."""
        ...

    connect_seconds: float
    """Time from plugging in until it is usable [s]."""

    responding: bool
    """False: it stays plugged in but sends no data any more."""

    def description(self, port: int) -> str:
        """What ``list`` prints for it at a port, 0 to 3: whole lines, each ending in CR LF."""
        ...

    def power_up(self) -> None:
        """It has just been given power: what it counts starts again from here."""
        ...

    def sample(self, current: float) -> bool:
        """Measure if its time has come; ``current`` [s] is the board's clock and never goes back.

        Returns:
            Whether there is a new message. To be called every millisecond, or as often as wanted.
        """
        ...

    def read(self, mode: int) -> tuple[int | float, ...]:
        """The values of a mode in the newest message, in the device's own numbers.

        Raises:
            DeviceError: there is no such mode.
        """
        ...


class DeviceError(ValueError):
    """A device was asked for something that it does not have."""


class Plant(Protocol):
    """What one port's driver turns; degrees here, since that is what a motor counts."""

    @property
    def angle(self) -> float:
        """Angle of the shaft [deg], never wrapped; clockwise is positive, as POS counts."""
        ...

    @property
    def speed(self) -> float:
        """Angular velocity of the shaft [deg/s]."""
        ...

    def drive(self, duty: float | None) -> None:
        """The driver puts out this part of its voltage from now on, -1..1.

        0 brakes, for the driver then shorts the motor; None lets it run out, unconnected.
        """
        ...


class Plants(Protocol):
    """What all ports' drivers turn; it has no clock but its steps."""

    supply_v: float
    """What the board is supplied with [V]; the board keeps it up to date."""

    def plant(self, port: int) -> Plant:
        """What turns at a port, 0 to 3, whether or not a device is plugged in there."""
        ...

    def step(self, seconds: float) -> None:
        """Let time [s] pass for all of them together."""
        ...
