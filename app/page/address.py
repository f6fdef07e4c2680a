"""The addresses of the page, for people to open."""

from __future__ import annotations

import socket

ELSEWHERE = ("192.0.2.1", 9)
"""An address of documentation (RFC 5737): to connect a UDP socket to it sends nothing."""


def address_of(listening: socket.socket, scheme: str = "http") -> str:
    """Return the page's address on a listening socket."""
    host, port = listening.getsockname()[:2]
    if host in ("0.0.0.0", "::"):
        host = own_address()  # a browser cannot open "all addresses"
    shown = f"[{host}]" if ":" in host else host
    return f"{scheme}://{shown}:{port}"


def own_address() -> str:
    """Return this machine's address in its network; its name, if there is no network."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.connect(ELSEWHERE)
        except OSError:
            return socket.gethostname()
        return str(probe.getsockname()[0])
