"""What a Build HAT says before its firmware runs, while the firmware is sent to it."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class BootloaderVersion:
    """The bootloader tells its version: seconds since 1970, and the same as a date."""

    version: int
    date: str


@dataclass(frozen=True, slots=True)
class BootloaderPrompt:
    """The bootloader waits for a command; its prompt has no end of line."""


@dataclass(frozen=True, slots=True)
class ImageReceived:
    """The firmware's image has arrived whole; its sum is checked next."""


@dataclass(frozen=True, slots=True)
class ChecksumOk:
    """The image's sum is the one that was announced."""


@dataclass(frozen=True, slots=True)
class ChecksumFailure:
    """The image's sum is another one; an ``Error`` follows."""


@dataclass(frozen=True, slots=True)
class SignatureReceived:
    """The signature has arrived; it is not checked before the reboot."""


@dataclass(frozen=True, slots=True)
class UploadTimeout:
    """A second went by without the byte that was to come; an ``Error`` follows."""


@dataclass(frozen=True, slots=True)
class UploadRefused:
    """What was announced can never be taken: too large, of a wrong length, or missing."""

    text: str


@dataclass(frozen=True, slots=True)
class Verified:
    """Image and signature belong together."""


@dataclass(frozen=True, slots=True)
class VerificationFailed:
    """The signature is not the image's; an ``Error`` follows."""


@dataclass(frozen=True, slots=True)
class Rebooting:
    """The bootloader jumps to the image in 100 ms."""
