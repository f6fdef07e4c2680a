"""Troubles at the start: messages that say why a Build HAT is not ready, each with its cure."""

from __future__ import annotations

from robot.hat.start.firmware_image import EXPECTED_VERSION

SERIAL_PORT = "sudo raspi-config, Interface Options, Serial Port: login shell no, hardware yes"
POWER_CYCLE = "switch its supply off and on"

SILENT = (
    "The Build HAT does not answer. Check that it sits on all 40 pins and has its own supply of "
    f"8 V; that the serial port is on and its login shell off ({SERIAL_PORT}; then reboot); "
    "that the device is the one on the header, which is /dev/ttyAMA0 on a Pi 5; and that 1-Wire "
    "is off (raspi-config, Interface Options), for it holds the board's reset pin."
)
HALF_HEARD = (
    "A Build HAT speaks, but its answers do not arrive whole: another program reads from the same "
    f"port. End it, or if it is the login shell: {SERIAL_PORT}; then reboot."
)


def login_shell(said: bytes) -> str:
    """Return the message for a login shell that answers instead of the board."""
    return (
        f"A login shell is at the serial port, it says {_quoted(said)}. Switch it off: "
        f"{SERIAL_PORT}; then reboot."
    )


def stranger(said: bytes) -> str:
    """Return the message for something else that answers instead of the board."""
    return (
        f"What is at the serial port is no Build HAT, it says {_quoted(said)}. Name the right "
        "port; on a Raspberry Pi it is /dev/serial0, on a Pi 5 /dev/ttyAMA0."
    )


def wrong_version(version: int) -> str:
    """Return the message for a wrong firmware, which a reset will remove."""
    return f"The Build HAT runs firmware {version}, not {EXPECTED_VERSION}; it is being reset."


def no_reset(version: int | None, reason: str) -> str:
    """Return the message for a wrong firmware on a board that cannot be reset."""
    return (
        f"The Build HAT runs firmware {version}, not {EXPECTED_VERSION}, and cannot be reset: "
        f"{reason}; or {POWER_CYCLE}."
    )


def upload_failed(tries: int, reason: str) -> str:
    """Return the message for a firmware that does not arrive."""
    return (
        f"The Build HAT did not take its firmware in {tries} tries: {reason}. Check that it sits "
        f"firmly on all 40 pins and that no other program uses the port, and {POWER_CYCLE}."
    )


def _quoted(said: bytes) -> str:
    return repr(said[:60].decode("utf-8", "replace").strip())
