"""Messages of a Build HAT and of its bootloader, as events.

Ports are 0 to 3 (A to D). A message without a port concerns the whole board.
"""

from __future__ import annotations

from dataclasses import dataclass


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
class InitDone:
    """The firmware has started and accepts commands; its devices connect seconds later."""


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
class CombiData:
    """A report of a combination of modes, in the device's own units and the requested order."""

    port: int
    slot: int
    values: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class SupplyVoltage:
    """The supply's voltage [V]."""

    volts: float


@dataclass(frozen=True, slots=True)
class MotorPowerFault:
    """A motor driver has a fault; repeated each second while it lasts. No motor is stopped."""


@dataclass(frozen=True, slots=True)
class PortPowerFault:
    """The ports' 3.3 V are overloaded; repeated each second while it lasts."""


@dataclass(frozen=True, slots=True)
class BootloaderVersion:
    """The bootloader's version: seconds since 1970, and the same as a date."""

    version: int
    date: str


@dataclass(frozen=True, slots=True)
class BootloaderPrompt:
    """The bootloader waits for a command; its prompt has no end of line."""


@dataclass(frozen=True, slots=True)
class ChecksumOk:
    """The image's checksum is the announced one."""


@dataclass(frozen=True, slots=True)
class ChecksumFailure:
    """The image's checksum is not the announced one; an ``Error`` follows."""


@dataclass(frozen=True, slots=True)
class SignatureReceived:
    """The signature has arrived; it is not checked before the reboot."""


@dataclass(frozen=True, slots=True)
class UploadTimeout:
    """An expected byte did not come within a second; an ``Error`` follows."""


@dataclass(frozen=True, slots=True)
class UploadRefused:
    """The announced data cannot be accepted: too large, of a wrong length, or missing."""

    text: str


@dataclass(frozen=True, slots=True)
class VerificationFailed:
    """The signature does not match the image; an ``Error`` follows."""


@dataclass(frozen=True, slots=True)
class Notice:
    """A line that a Build HAT sends and that changes nothing here, as ``P0: pulse done``."""

    text: str


@dataclass(frozen=True, slots=True)
class Echo:
    """A command as the board received it; the bootloader always echoes, the firmware on request."""

    text: str


@dataclass(frozen=True, slots=True)
class UnknownLine:
    """A line that no Build HAT sends: garbled, cut, or from something else. Long ones are cut."""

    raw: bytes


Event = (
    Answered
    | CommandRefused
    | FirmwareVersion
    | InitDone
    | Connected
    | Established
    | NoDevice
    | Disconnected
    | ConnectionFailed
    | CombiData
    | SupplyVoltage
    | MotorPowerFault
    | PortPowerFault
    | BootloaderVersion
    | BootloaderPrompt
    | ChecksumOk
    | ChecksumFailure
    | SignatureReceived
    | UploadTimeout
    | UploadRefused
    | VerificationFailed
    | Notice
    | Echo
    | UnknownLine
)
"""Any message of a Build HAT."""
