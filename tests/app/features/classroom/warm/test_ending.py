"""What a class has started ends with it, and nothing else does."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from app.features.classroom.warm.ending import STUDENT_OF, end_others

DEAF = "import signal; signal.signal(signal.SIGTERM, signal.SIG_IGN); print(flush=True); input()"
"""A process that does not end when it is told to."""
WILLING = "print(flush=True); input()"


@pytest.fixture
def begun() -> Iterator[list[subprocess.Popen[bytes]]]:
    processes: list[subprocess.Popen[bytes]] = []
    yield processes
    for process in processes:
        process.kill()
        process.communicate()


@pytest.mark.parametrize("script", [WILLING, DEAF])
def test_servers_of_this_class_end_and_those_of_others_do_not(
    script: str, begun: list[subprocess.Popen[bytes]], tmp_path: Path
) -> None:
    for name in ("a.class", "a.class2"):
        environment = os.environ | {STUDENT_OF: str(tmp_path / name)}
        pipe = subprocess.PIPE
        process = subprocess.Popen(
            [sys.executable, "-c", script], env=environment, stdin=pipe, stdout=pipe
        )
        begun.append(process)
        assert process.stdout is not None
        process.stdout.readline()  # it has begun, and is deaf if it shall be
    end_others(tmp_path / "a.class", 0.3)
    assert begun[0].wait(timeout=20) != 0
    assert begun[1].poll() is None
