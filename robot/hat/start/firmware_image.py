"""The Build HAT's firmware, which is sent to it after each power-up.

It is not part of this program. It comes with the official library, whose data is read without
running any of its code.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from importlib.util import find_spec
from pathlib import Path

from robot.errors import BrickPoseError

EXPECTED_VERSION = 1737564117
"""Version of the firmware that the driver supports, of 22 January 2025."""

LONGEST = 245_760
SIGNATURE_LENGTH = 64
CURE = "install the one with it: pip install buildhat==0.9.0"


class FirmwareImageError(BrickPoseError, RuntimeError):
    """There is no firmware to send; the message says where to get it."""


@dataclass(frozen=True, slots=True)
class FirmwareImage:
    """A firmware in the form that the bootloader accepts."""

    version: int
    """Seconds since 1970."""
    data: bytes = field(repr=False)
    signature: bytes = field(repr=False)
    """Signature of the data; 64 bytes."""

    def __post_init__(self) -> None:
        if not 0 < len(self.data) <= LONGEST:
            raise FirmwareImageError(
                f"the firmware has {len(self.data)} bytes, valid are 1 to {LONGEST}; {CURE}"
            )
        if len(self.signature) != SIGNATURE_LENGTH:
            raise FirmwareImageError(
                f"the firmware's signature has {len(self.signature)} bytes, "
                f"valid are {SIGNATURE_LENGTH}; {CURE}"
            )

    @property
    def checksum(self) -> int:
        """The checksum that the bootloader compares."""
        return checksum(self.data)

    @classmethod
    def installed(cls, package: str = "buildhat") -> FirmwareImage:
        """Read the firmware from the installed official library, without importing it.

        Raises:
            FirmwareImageError: there is no firmware, or it has another version; the message says
                what to install.
        """
        folder = _data_folder(package)
        try:
            text = (folder / "version").read_text(encoding="utf-8")
            data = (folder / "firmware.bin").read_bytes()
            signature = (folder / "signature.bin").read_bytes()
        except OSError as error:
            raise FirmwareImageError(f"{package} has no firmware: {error}; {CURE}") from error
        if text.strip() != str(EXPECTED_VERSION):
            raise FirmwareImageError(
                f"{package} has firmware {text.strip()!r}, not {EXPECTED_VERSION}; {CURE}"
            )
        return cls(EXPECTED_VERSION, data, signature)


def checksum(data: bytes) -> int:
    """Return the bootloader's checksum: a 32-bit register that starts at 1.

    Each byte shifts the register, folds it by 0x1D872B41 and is then combined with it by XOR.
    """
    register = 1
    for byte in data:
        register <<= 1
        if register >> 32:
            register = (register & 0xFFFFFFFF) ^ 0x1D872B41
        register ^= byte
    return register


def _data_folder(package: str) -> Path:
    spec = find_spec(package)
    if spec is None or not spec.submodule_search_locations:
        raise FirmwareImageError(
            f"the Build HAT's firmware comes with the package {package}, which is not installed; "
            + CURE
        )
    return Path(spec.submodule_search_locations[0]) / "data"
