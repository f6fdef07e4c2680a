"""A real reverse proxy before a program: JupyterHub's, of npm or in Python."""

from __future__ import annotations

import importlib.util
import json
import os
import shutil
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from urllib.request import Request, urlopen

import pytest

NAME = "configurable-http-proxy"
IN_PYTHON = importlib.util.find_spec(NAME.replace("-", "_")) is not None
START = "from configurable_http_proxy.cli import main; main()"
COMMAND = [sys.executable, "-c", START] if IN_PYTHON else [shutil.which(NAME)]
needs_proxy = pytest.mark.skipif(
    COMMAND == [None], reason=f"{NAME} is not there; `python -m pip install {NAME}` gets it"
)
START_S = 30.0


def free_ports(count: int) -> list[int]:
    """Ports that nobody listens on now."""
    sockets = [socket.socket() for _ in range(count)]
    for each in sockets:
        each.bind(("127.0.0.1", 0))
    ports = [each.getsockname()[1] for each in sockets]
    for each in sockets:
        each.close()
    return ports


@contextmanager
def proxied(path: str, target: str, *, strips: bool) -> Iterator[str]:
    """The address of a program behind a proxy, below a path that the proxy keeps or takes away."""
    port, own = free_ports(2)
    words = [
        "--ip",
        "127.0.0.1",
        "--port",
        str(port),
        "--api-port",
        str(own),
        "--log-level",
        "error",
    ]
    words += ["--no-include-prefix"] if strips else []
    process = subprocess.Popen(
        [*map(str, COMMAND), *words], env=os.environ | {"CONFIGPROXY_AUTH_TOKEN": "of-the-test"}
    )
    try:
        _route(f"http://127.0.0.1:{own}/api/routes{path}", target)
        yield f"http://127.0.0.1:{port}{path}"
    finally:
        process.terminate()
        process.wait(START_S)


def _route(address: str, target: str) -> None:
    body = json.dumps({"target": target}).encode()
    headers = {"Authorization": "token of-the-test", "Content-Type": "application/json"}
    end = time.monotonic() + START_S
    while True:
        try:
            urlopen(Request(address, body, headers), timeout=START_S).close()
        except OSError:  # it does not listen yet
            if time.monotonic() > end:
                raise
        else:
            return
