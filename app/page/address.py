"""The address of the page."""

from __future__ import annotations

import socket


def address_of(listening: socket.socket) -> str:
    """Return the page's address on a listening socket."""
    host, port = listening.getsockname()[:2]
    if host in ("0.0.0.0", "::"):
        host = socket.gethostname()  # a browser cannot open "all addresses"
    shown = f"[{host}]" if ":" in host else host
    return f"http://{shown}:{port}"
