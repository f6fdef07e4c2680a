"""Serves the dashboard once, in the warm parent: what first requests make is shared by all copies.

Python counts the first calls of each function, notes which methods a type has when one is first
asked for, and the libraries of the server keep what they have worked out. All of that is written
beside code that copies share, so each copy would have pages of its own for it.
"""

from __future__ import annotations

import importlib
import json
import os
import signal
import socket
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from urllib.request import ProxyHandler, build_opener

from websockets.sync.client import connect

DRIVES_S = 1.5
"""Time for which a page drives [s]. Half or twice of it changes by less than 1 MB what a copy has
of its own, and by as much when a class is ready."""
PATIENCE_S = 60.0
PAGES = ("learn/1", "", "api/field", "api/field.png", "api/parameters", "api/progress", "api/help")


def serve_once() -> None:
    """Serve a robot to one page that drives it, in this process; nothing of it is kept on disk."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    with _elsewhere(), suppress(SystemExit, KeyboardInterrupt):
        page = threading.Thread(target=_look, args=(port,), name="first page")
        page.start()
        try:
            words = ("learn", "--host", "127.0.0.1", "--port", str(port), "--no-token")
            sys.argv = ["brickpose", *words, "--one-process"]
            importlib.import_module("app.__main__").main()
        finally:
            page.join(PATIENCE_S)


@contextmanager
def _elsewhere() -> Iterator[None]:
    """Be in a folder that is removed, with an environment of one's own."""
    before, folder, words = dict(os.environ), os.getcwd(), sys.argv  # noqa: PTH109 - to go back
    with tempfile.TemporaryDirectory() as home:
        os.chdir(home)
        for name in ("HOME", "XDG_DATA_HOME", "XDG_STATE_HOME"):
            os.environ[name] = home
        try:
            yield
        finally:
            os.chdir(folder)
            os.environ.clear()
            os.environ.update(before)
            sys.argv = words


def _look(port: int) -> None:
    """Be a page that drives for a moment; then the server is asked to end."""
    try:
        with suppress(OSError, TimeoutError):
            _read(port)
            _drive(port)
    finally:
        os.kill(os.getpid(), signal.SIGINT)


def _read(port: int) -> None:
    end = time.monotonic() + PATIENCE_S
    while True:
        try:
            socket.create_connection(("127.0.0.1", port)).close()
            break
        except OSError:
            if time.monotonic() > end:
                raise
            time.sleep(0.02)
    opener = build_opener(ProxyHandler({}))
    for page in PAGES:
        with suppress(OSError):  # a feature may be left out
            opener.open(f"http://127.0.0.1:{port}/{page}", timeout=PATIENCE_S).read()


def _drive(port: int) -> None:
    place = f"ws://127.0.0.1:{port}/api/"
    with (
        connect(f"{place}live?rate=30", max_size=None, proxy=None) as live,
        connect(f"{place}camera", max_size=None, proxy=None) as camera,
    ):
        number, end = 0, time.monotonic() + DRIVES_S
        while time.monotonic() < end:
            json.loads(live.recv(timeout=PATIENCE_S))
            number += 1
            live.send(json.dumps({"type": "drive", "v": 0.1, "omega": 0.5, "id": number}))
            with suppress(TimeoutError):
                camera.recv(timeout=0)
