"""Programs of tests/node, which use packages of npm: clients and readers that are not ours."""

import functools
import json
import re
import shutil
import subprocess
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import IO

import pytest
from places import TESTS

SCRIPTS = TESTS / "node"
MODULES = SCRIPTS.parents[1] / ".venv"
LONGEST_S = 40.0


@functools.cache
def missing() -> str | None:
    """Why they cannot run here; None if they can."""
    if shutil.which("node") is None:
        return "node is not installed"
    version = subprocess.run(["node", "--version"], capture_output=True, text=True, check=True)
    if int(re.findall(r"\d+", version.stdout)[0]) < 20:
        return f"node {version.stdout.strip()} is older than 20"
    if not (MODULES / "node_modules").is_dir():
        return "the packages of npm are not there; `make node-peers` gets them"
    return None


needs_node = pytest.mark.skipif(missing() is not None, reason=str(missing()))


class Peer:
    """A script that runs. Its lines go to a file: a pipe that nobody empties would stop it."""

    def __init__(self, process: subprocess.Popen, out: IO[str]) -> None:
        self._process = process
        self._out = out

    def runs(self) -> bool:
        return self._process.poll() is None

    def told(self) -> list[dict]:
        """All that it wrote, once it has ended."""
        with suppress(subprocess.TimeoutExpired):
            self._process.wait(LONGEST_S)
        self._out.seek(0)
        lines = self._out.read().splitlines()
        shown = "\n".join(line[:300] for line in lines[-20:])
        assert self._process.returncode == 0, f"{self._process.returncode}; it said:\n{shown}"
        return [json.loads(line) for line in lines if line.startswith("{")]


@contextmanager
def start_node(script: str, *arguments) -> Iterator[Peer]:
    """Start one of the scripts; arguments that are no text are handed over as JSON."""
    words = [one if isinstance(one, str) else json.dumps(one) for one in arguments]
    with (
        (SCRIPTS / script).open(encoding="utf-8") as text,
        tempfile.TemporaryFile("w+", encoding="utf-8") as out,
    ):
        process = subprocess.Popen(
            # As text: where its packages are is looked up from the working directory then.
            ["node", "--input-type=module", "-", *words],
            stdin=text,
            stdout=out,
            stderr=subprocess.STDOUT,
            cwd=MODULES,
        )
        try:
            yield Peer(process, out)
        finally:
            process.kill()
            process.wait()


def run_node(script: str, *arguments) -> list[dict]:
    """Run one of the scripts; returns the lines of JSON that it writes."""
    with start_node(script, *arguments) as peer:
        return peer.told()
