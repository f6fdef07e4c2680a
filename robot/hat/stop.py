"""Stops the motors of a Build HAT that no program drives any more."""

from __future__ import annotations

from robot.errors import PortError
from robot.hat.protocol import commands
from robot.hat.serial_port import SerialPort

PATIENCE_S = 1.0
"""Longest time for sending the stop [s]; a line of 63 bytes takes 5 ms."""


def stop_motors(device: str) -> None:
    """Tell all four ports to brake.

    Use it when a program ended without stopping the motors. If it was this program, the pulses in
    the firmware have ended by then. Motors started by another program keep turning.

    Raises:
        PortError: the port cannot be opened, or takes no bytes; the message says why, and the
            cure.
    """
    port = SerialPort(device)
    try:
        # A killed program may have left half a line: CR ends it, so that the stop is a line of its
        # own. Sent twice: if a byte of the first is lost, a motor can stay at the old set-point.
        if not port.finish(b"\r" + 2 * commands.stop(), PATIENCE_S):
            raise PortError(f"{device} takes no bytes; is what is behind it stopped?")
    finally:
        port.close()
