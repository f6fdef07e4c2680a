"""Keeps a process's UDP sockets to this machine.

Cyclone DDS sends on the configured interface, but its sockets listen on all interfaces. So another
machine could still send commands and drive the robot. Sockets that are bound to the loopback
device receive only what was sent on this machine, to any of its addresses.
"""

from __future__ import annotations

import contextlib
import os
import socket
import sys
from collections.abc import Iterator
from pathlib import Path

from robot.errors import BrickPoseError

DEVICE = b"lo\0"


class ConfinementError(BrickPoseError, OSError):
    """The system does not allow binding the sockets to the loopback device."""


def confine_to_this_machine() -> None:
    """Bind each UDP socket of this process to the loopback device.

    Raises:
        ConfinementError: the system does not allow it.
    """
    if not sys.platform.startswith("linux"):
        raise ConfinementError("only Linux can keep DDS to this machine")
    for each in _udp_sockets():
        with each:
            try:
                each.setsockopt(socket.SOL_SOCKET, socket.SO_BINDTODEVICE, DEVICE)
            except OSError as error:
                raise ConfinementError(
                    f"DDS cannot be kept to this machine ({error.strerror}); Linux 5.7 or newer can"
                ) from error


def _udp_sockets() -> Iterator[socket.socket]:
    for entry in Path("/proc/self/fd").iterdir():
        with contextlib.suppress(OSError):  # the folder's own descriptor is closed by now
            if not str(entry.readlink()).startswith("socket:"):
                continue
            item = socket.socket(fileno=os.dup(int(entry.name)))
            if item.family in (socket.AF_INET, socket.AF_INET6) and item.type == socket.SOCK_DGRAM:
                yield item
            else:
                item.close()
