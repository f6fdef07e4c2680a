"""What people open."""

from __future__ import annotations

import socket


def address_of(listening: socket.socket) -> str:
    """The page's address, of a socket that listens."""
    host, port = listening.getsockname()[:2]
    if host in ("0.0.0.0", "::"):
        host = socket.gethostname()  # nobody can open "all addresses"
    shown = f"[{host}]" if ":" in host else host
    return f"http://{shown}:{port}"
