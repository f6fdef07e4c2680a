"""A class under test: a real JupyterHub with its proxy, and browsers of its students."""

from __future__ import annotations

import importlib.util
import json
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import pytest
from playwright.sync_api import Browser, Page
from reverse_proxies import free_ports

from benchmarks.programs import started

NEEDED = ("jupyterhub", "jupyterhub_idle_culler", "configurable_http_proxy")
MISSING = [name for name in NEEDED if importlib.util.find_spec(name) is None]
needs_hub = pytest.mark.skipif(
    bool(MISSING) or sys.platform == "win32",
    reason=f"{', '.join(MISSING) or 'JupyterHub'} is not there; "
    "`python -m pip install -c constraints.txt 'brickpose[class]'` gets it",
)


@dataclass(frozen=True)
class RunningClass:
    """A class that is served."""

    process: subprocess.Popen[str]
    address: str
    folder: Path

    @property
    def keys(self) -> dict[str, str]:
        """The keys of links, by what the hub calls people."""
        return json.loads((self.folder / "keys.json").read_text())

    def link(self, login: str) -> str:
        """What a person opens."""
        return f"{self.address}/hub/enter/{self.keys[login]}"

    def enter(self, browser: Browser, login: str) -> Page:
        """A student's dashboard, in a browser of their own, opened by the link."""
        page = browser.new_context().new_page()
        page.set_default_timeout(90_000)
        page.goto(self.link(login))
        page.wait_for_url(f"**/user/{login}/learn/1")
        page.goto(f"{self.address}/user/{login}/")
        page.wait_for_function(
            "window.brickpose?.connected && window.brickpose?.telemetry?.estimate"
        )
        return page


def four_ports() -> int:
    """The first of four free ports, one after the other."""
    while True:
        (first,) = free_ports(1)
        if first < 65_000 and set(range(first, first + 4)) <= set(_free(first)):
            return first


def _free(first: int) -> Iterator[int]:
    import socket

    for port in range(first, first + 4):
        with socket.socket() as probe:
            try:
                probe.bind(("127.0.0.1", port))
            except OSError:
                return
            yield port


@contextmanager
def running_class(folder: Path, names: str, *words: str) -> Iterator[RunningClass]:
    """Serve a class of these names, one a line."""
    students = folder / "students.csv"
    students.write_text(names, encoding="utf-8")
    port = four_ports()
    options = ("class", str(students), "--host", "127.0.0.1", "--port", str(port), *words)
    with started(*options, says=r"students at (http://\S+)") as (process, address):
        yield RunningClass(process, address, folder / "students.class")
