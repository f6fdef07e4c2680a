"""A robot that nobody looks at sleeps, and is there at the next look."""

from __future__ import annotations

import asyncio
import subprocess
import sys
import time
from pathlib import Path
from types import SimpleNamespace

import pytest

from app.features.classroom.sleep import Sleeper

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="the hub does not run on Windows")
LONGEST_S = 20.0


def program(mode: str = "idle", *, recorded: bool = False, replay: bool = False):
    latest = SimpleNamespace(get=lambda: SimpleNamespace(mode=mode))
    engine = SimpleNamespace(every=SimpleNamespace(subscribed=recorded), latest=latest)
    return SimpleNamespace(engine=engine, loop=(lambda: None) if replay else None)


@pytest.fixture
def process():
    with subprocess.Popen(["sleep", "600"]) as running:
        yield running
        running.kill()


def state_of(process: subprocess.Popen) -> str:
    return Path(f"/proc/{process.pid}/stat").read_text().rpartition(")")[2].split()[0]


async def until(condition) -> None:
    end = time.monotonic() + LONGEST_S
    while not condition():
        assert time.monotonic() < end
        await asyncio.sleep(0.005)


@pytest.mark.skipif(sys.platform != "linux", reason="reads /proc")
def test_it_stands_still_when_the_last_one_has_gone_and_goes_on_at_the_next_look(process):
    held: list[bool] = []
    watched = program()
    watched.engine.hold = held.append

    async def run() -> None:
        sleeper = Sleeper(0.02, lambda: [process.pid])
        sleeper.watch(watched)
        with sleeper.looked():
            with sleeper.looked():
                pass
            await asyncio.sleep(0.1)  # five times as long as it would take
            assert not sleeper.asleep
        await until(lambda: state_of(process) == "T")
        assert sleeper.asleep
        with sleeper.looked():
            await until(lambda: state_of(process) == "S")
            assert not sleeper.asleep

    asyncio.run(run())
    assert held == [True, False]


@pytest.mark.parametrize(
    "busy", [program("figure-eight"), program(recorded=True), program(replay=True), None]
)
def test_what_goes_on_without_viewers_is_not_held_up(busy):
    stopped: list[bool] = []

    async def run() -> None:
        sleeper = Sleeper(0.01, lambda: stopped.append(True) or [])
        if busy is not None:
            sleeper.watch(busy)
        with sleeper.looked():
            pass
        await asyncio.sleep(0.06)
        assert not sleeper.asleep
        sleeper.watch(program())
        await until(lambda: sleeper.asleep)

    asyncio.run(run())
    assert len(stopped) == 1
