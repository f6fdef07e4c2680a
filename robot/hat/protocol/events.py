"""Messages of a Build HAT, one type for every kind of line.

Ports are 0 to 3 (A to D). A message without a port concerns the whole board.
"""

from __future__ import annotations

from dataclasses import dataclass

from robot.hat.protocol.bootloader_events import (
    BootloaderPrompt,
    BootloaderVersion,
    ChecksumFailure,
    ChecksumOk,
    ImageReceived,
    Rebooting,
    SignatureReceived,
    UploadRefused,
    UploadTimeout,
    VerificationFailed,
    Verified,
)


@dataclass(frozen=True, slots=True)
class Answered:
    """The blank line that the board sends first after every command line, successful or not."""


@dataclass(frozen=True, slots=True)
class CommandRefused:
    """A command was not understood. The rest of its line was dropped; the part before it ran."""


@dataclass(frozen=True, slots=True)
class FirmwareVersion:
    """The firmware's version: seconds since 1970, and the same as a date."""

    version: int
    date: str


@dataclass(frozen=True, slots=True)
class Signature:
    """The firmware's signature as hexadecimal text."""

    text: str


@dataclass(frozen=True, slots=True)
class InitDone:
    """The firmware has started and accepts commands; its devices connect seconds later."""


@dataclass(frozen=True, slots=True)
class Connecting:
    """A device answers at a port; it can be used only seconds later."""

    port: int


@dataclass(frozen=True, slots=True)
class Connected:
    """A device of that type is at a port: newly plugged in, or named in an answer to list.

    A newly plugged-in device can be used from ``Established`` on, a passive one at once.
    """

    port: int
    type_id: int
    passive: bool


@dataclass(frozen=True, slots=True)
class Established:
    """A newly plugged-in device can be used."""

    port: int
    type_id: int


@dataclass(frozen=True, slots=True)
class NoDevice:
    """No device is at a port; the board says so only in an answer to list."""

    port: int


@dataclass(frozen=True, slots=True)
class Disconnected:
    """A usable device is gone, and with it all settings of its port."""

    port: int


@dataclass(frozen=True, slots=True)
class ConnectionFailed:
    """A connection broke off; if the device was usable, ``Disconnected`` follows."""

    port: int
    reason: str


@dataclass(frozen=True, slots=True)
class PulseDone:
    """A pulse ended by itself: no program renewed it."""

    port: int


@dataclass(frozen=True, slots=True)
class RampDone:
    """A ramp reached its end."""

    port: int


@dataclass(frozen=True, slots=True)
class Button:
    """The button of a passive device."""

    port: int
    pressed: bool


@dataclass(frozen=True, slots=True)
class ModeData:
    """A report of one mode, in the device's own units."""

    port: int
    mode: int
    values: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class CombiData:
    """A report of a combination of modes, in the device's own units and the requested order."""

    port: int
    slot: int
    values: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class Value:
    """A report of one value from a device's data; it may be NaN or infinite."""

    port: int
    value: float


@dataclass(frozen=True, slots=True)
class Supply:
    """The supply's voltage [V]."""

    volts: float


@dataclass(frozen=True, slots=True)
class MotorPowerFault:
    """A motor driver has a fault; repeated each second while it lasts. No motor is stopped."""


@dataclass(frozen=True, slots=True)
class PortPowerFault:
    """The ports' 3.3 V are overloaded; repeated each second while it lasts."""


@dataclass(frozen=True, slots=True)
class FaultDump:
    """The motor drivers' registers, after a motor power fault."""

    text: str


@dataclass(frozen=True, slots=True)
class Late:
    """Time that the firmware's main loop took [ms]; it is reported above 2 ms."""

    ms: int


@dataclass(frozen=True, slots=True)
class QueueOverrun:
    """The firmware lost messages to a device."""


@dataclass(frozen=True, slots=True)
class BusFault:
    """The bus between the board's own chips failed."""

    text: str


@dataclass(frozen=True, slots=True)
class Banner:
    """Text for information only: at a start, at a connection and before a reboot."""

    text: str


@dataclass(frozen=True, slots=True)
class DescriptionLine:
    """One line of a device's description."""

    text: str


@dataclass(frozen=True, slots=True)
class Echo:
    """A command as the board received it; the bootloader always echoes, the firmware on request."""

    text: str


@dataclass(frozen=True, slots=True)
class Unknown:
    """A line that no Build HAT sends: garbled, cut, or from something else. Long ones are cut."""

    raw: bytes


Event = (
    Answered
    | CommandRefused
    | FirmwareVersion
    | BootloaderVersion
    | BootloaderPrompt
    | Connecting
    | Connected
    | Established
    | NoDevice
    | Disconnected
    | ConnectionFailed
    | PulseDone
    | RampDone
    | Button
    | ModeData
    | CombiData
    | Value
    | Supply
    | MotorPowerFault
    | PortPowerFault
    | FaultDump
    | Late
    | QueueOverrun
    | BusFault
    | InitDone
    | Banner
    | DescriptionLine
    | Echo
    | ImageReceived
    | ChecksumOk
    | ChecksumFailure
    | SignatureReceived
    | UploadTimeout
    | UploadRefused
    | Verified
    | VerificationFailed
    | Rebooting
    | Signature
    | Unknown
)
"""Any message of a Build HAT."""
