"""Messages of a Build HAT's bootloader, before the firmware runs and during its upload."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class BootloaderVersion:
    """The bootloader's version: seconds since 1970, and the same as a date."""

    version: int
    date: str


@dataclass(frozen=True, slots=True)
class BootloaderPrompt:
    """The bootloader waits for a command; its prompt has no end of line."""


@dataclass(frozen=True, slots=True)
class ImageReceived:
    """The firmware's image has arrived completely; its checksum is checked next."""


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
class Verified:
    """The signature matches the image."""


@dataclass(frozen=True, slots=True)
class VerificationFailed:
    """The signature does not match the image; an ``Error`` follows."""


@dataclass(frozen=True, slots=True)
class Rebooting:
    """The bootloader jumps to the image in 100 ms."""
