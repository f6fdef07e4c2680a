"""Limits the number of connections, and closes the most silent one to make room."""

from __future__ import annotations

import contextlib
import ipaddress
import socket
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Protocol

MOST = 512
"""Most connections; enough for some fifty pages."""
RESERVE = 32
"""Places reserved for websockets, so that a page that lost its socket gets one again."""
SHARE = 4
"""An address other than loopback gets at most one in this number of places."""


def places_to_watch(most: int) -> int:
    """Return how many of the places those get who only watch: others find one all the same."""
    return _open_to_all(most) * 3 // 4


def _open_to_all(most: int) -> int:
    return most - min(RESERVE, most // SHARE)


class AcceptedSocket(Protocol):
    """An accepted socket."""

    def fileno(self) -> int:
        """Its file descriptor; -1 after it was closed."""
        ...

    def shutdown(self, how: int, /) -> None:
        """Shut both directions down; the server notices that, and closes it."""
        ...


@dataclass
class _Guest:
    connection: AcceptedSocket
    address: str
    silent: bool = True
    """Whether it has no open request: none came yet, or all are answered."""


class Room:
    """All open connections of a server, by descriptor.

    A new connection gets a place if one is free. Otherwise, the connection that has been silent for
    longest is closed; a connection with an open request, such as the driver's, is never closed.
    """

    def __init__(self, most: int = MOST) -> None:
        self.most = most
        self._guests: dict[int, _Guest] = {}

    def admit(self, connection: AcceptedSocket, address: str) -> bool:
        """Give a connection a place; return False if there is none."""
        self._forget_closed()
        local = _is_local(address)
        same = [guest for guest in self._guests.values() if guest.address == address]
        crowded = not local and len(same) >= max(1, self.most // SHARE)
        full = len(self._guests) >= self.most
        if (crowded or full) and not self._release(same if crowded else self._guests.values()):
            return False
        self._guests[connection.fileno()] = _Guest(connection, address)
        return True

    def set_silent(self, descriptor: int, silent: bool) -> None:
        """Note whether a connection has no open request."""
        guest = self._guests.pop(descriptor, None)
        if guest is not None:
            guest.silent = silent
            self._guests[descriptor] = guest  # behind those that have been silent for longer

    @property
    def crowded(self) -> bool:
        """Whether connections with an open request take all places but the reserve."""
        self._forget_closed()
        busy = sum(not guest.silent for guest in self._guests.values())
        return busy >= _open_to_all(self.most)

    def release(self) -> bool:
        """Close the connection that has been silent for longest; return False if there is none."""
        self._forget_closed()
        return self._release(self._guests.values())

    def _release(self, guests: Iterable[_Guest]) -> bool:
        for guest in guests:
            if guest.silent:
                del self._guests[guest.connection.fileno()]
                with contextlib.suppress(OSError):  # the other end has gone already
                    guest.connection.shutdown(socket.SHUT_RDWR)
                return True
        return False

    def _forget_closed(self) -> None:
        self._guests = {
            descriptor: guest
            for descriptor, guest in self._guests.items()
            if guest.connection.fileno() == descriptor
        }


def _is_local(address: str) -> bool:
    """Whether an address is this computer's own, also an IPv4 address written as IPv6."""
    parsed = ipaddress.ip_address(address.partition("%")[0])
    mapped = parsed.ipv4_mapped if isinstance(parsed, ipaddress.IPv6Address) else None
    return (mapped or parsed).is_loopback
