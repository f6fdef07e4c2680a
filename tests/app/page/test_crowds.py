"""More connections than descriptors: who drives goes on, and a page opens."""

from __future__ import annotations

import json
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import httpx
import pytest
from places import HELPERS
from serving import ROOT, ServedProgram, ask, server, telemetry, until

from benchmarks.programs import estimated

LIMIT = 200
CROWD = 260
FEW_DESCRIPTORS = ("sh", "-c", f'ulimit -n {LIMIT} && exec "$@"', "sh")


@pytest.fixture(scope="module")
def crowded(tmp_path_factory) -> Iterator[tuple[ServedProgram, Path]]:
    """A program with few descriptors, and its log."""
    log = tmp_path_factory.mktemp("log") / "log.txt"
    options = ("--robot", "kinematic", "--map", "stub")
    with (
        log.open("w") as out,
        server(*options, stderr=out.fileno(), prefix=FEW_DESCRIPTORS) as running,
    ):
        with running.live() as live:
            until(live, estimated, 90)
        yield running, log


@contextmanager
def crowd(server: ServedProgram, count: int, begin: bytes = b"") -> Iterator[list[socket.socket]]:
    """Connections that say no more than a beginning."""
    host, port = server.address.split(":")
    with ExitStack() as stack:
        made = []
        for _ in range(count):
            one = stack.enter_context(socket.create_connection((host, int(port)), timeout=20))
            one.sendall(begin)
            made.append(one)
        yield made


def gap(live, seconds: float) -> float:
    """The longest time between two messages of telemetry, on the robot's clock and on ours [s]."""
    before = telemetry(live)["stamp"]
    end = before + seconds
    longest = 0.0
    while before < end:
        began = time.monotonic()
        stamp = telemetry(live)["stamp"]
        longest = max(longest, stamp - before, time.monotonic() - began)
        before = stamp
    return longest


@pytest.mark.real_time
@pytest.mark.parametrize("begin", [b"", b"GET / HTTP/1.1\r\nHost: "], ids=["idle", "half a head"])
def test_the_driver_goes_on_and_a_page_opens(crowded, begin) -> None:
    running, log = crowded
    lines = len(log.read_text().splitlines())
    with running.live() as live:
        assert ask(live, type="drive", v=0.05, omega=0.0)["type"] == "ack"
        with crowd(running, CROWD, begin):
            assert gap(live, 3.0) < 1.0
            assert ask(live, type="stop")["type"] == "ack"
            assert running.descriptors() < LIMIT
            assert httpx.get(running.url, timeout=20).status_code == 200
            with running.live() as second:
                assert telemetry(second)["robot"]["connected"]
                assert ask(second, type="take")["type"] == "ack"
        assert httpx.get(running.url, timeout=20).status_code == 200
        until(live, lambda now: running.descriptors() < 40)
    assert len(log.read_text().splitlines()) - lines < 30


@pytest.mark.real_time
def test_health_is_good_afterwards(crowded) -> None:
    running, _ = crowded
    assert httpx.get(f"{running.url}/api/health", timeout=20).json()["status"] == "ok"


def test_descriptors_that_are_used_up_otherwise_drop_who_waits(tmp_path) -> None:
    """In a process of its own: it has all its descriptors open when connections come."""
    code = (HELPERS / "used_up_descriptors.py").as_posix()
    ended = subprocess.run(
        [*FEW_DESCRIPTORS, sys.executable, code], capture_output=True, text=True, check=False
    )
    assert ended.returncode == 0, ended.stderr[-3000:]
    told = json.loads(ended.stdout)
    assert told == {"raised": "BlockingIOError", "closed": True, "later": True}


@pytest.mark.parametrize(("soft", "hard", "raised"), [(100, 300, 300), (300, 300, 300)])
def test_the_soft_limit_of_descriptors_is_raised(soft, hard, raised) -> None:
    code = (
        "import resource; from app.operating_system import raise_descriptors; "
        "print(raise_descriptors(), resource.getrlimit(resource.RLIMIT_NOFILE)[0])"
    )
    limits = ("sh", "-c", f'ulimit -S -n {soft} && ulimit -H -n {hard} && exec "$@"', "sh")
    words = [*limits, sys.executable, "-c", code]
    told = subprocess.run(words, capture_output=True, text=True, check=True, cwd=ROOT).stdout
    assert told.split() == [str(raised)] * 2
