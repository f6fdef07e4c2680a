"""Stops the motors of a Build HAT that no program drives any more."""

from __future__ import annotations

from robot.hat.protocol import commands
from robot.hat.serial_port import PortError, SerialPort

PATIENCE_S = 1.0
"""A line of 63 bytes takes 5 ms [s]."""


def stop_motors(device: str) -> None:
    """Tell all four ports to brake.

    It is for when a program ended without it: the pulses in the firmware have ended by then, if
    it was this one, but another's motors turn for ever.

    Raises:
        PortError: the port cannot be opened, or takes nothing; says why, and the cure.
    """
    port = SerialPort(device)
    try:
        # Who was killed may have left half a line; its end keeps the stop from being a part of it.
        # Twice: a byte that is lost in the first can leave a motor at the old set-point.
        if not port.finish(b"\r" + 2 * commands.stop(), PATIENCE_S):
            raise PortError(f"{device} takes no bytes; is what is behind it stopped?")
    finally:
        port.close()
