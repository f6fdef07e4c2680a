"""Keeps a process's UDP sockets to this machine.

Cyclone DDS sends by the interface that it is told, but its sockets listen on all of them: another
machine could still drive the robot by what it sends there. Bound to the loopback device they
receive only what was sent on this machine, to whichever of its addresses.
"""

from __future__ import annotations

import contextlib
import os
import socket
import sys
from collections.abc import Iterator
from pathlib import Path

DEVICE = b"lo\0"


class ConfinementError(OSError):
    """The system does not allow it."""


def confine_to_this_machine() -> None:
    """Bind each UDP socket of this process to the loopback device.

    Raises:
        ConfinementError: it cannot be done.
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
