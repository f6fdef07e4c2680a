"""The camera of a served program rests; whoever looks wakes it, for as long as they look."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager

import pytest
from apps import listening
from httpx import get, stream
from websockets.sync.client import connect

from app.engine.build import build_program
from app.engine.engine_thread import EngineThread
from app.engine.plugging import plugged
from app.engine.program import Program
from app.engine.rest import VISIT_S, WATCHED_PERIOD
from app.engine.snapshot import Snapshot
from app.features.calibration.lens.desk import PERIOD_S
from app.page.outlets import Outlets
from app.page.server import create_app
from app.page.view.viewers import PROTOCOL
from app.settings.config import Config
from sim.real_time import RealTime

pytestmark = pytest.mark.slow

WINDOW_S = 0.6
"""Pictures are counted for this time [s]."""
RESTS_S = VISIT_S + PERIOD_S + 3.0
"""Time after which the camera rests, once nobody looks [s]."""


@pytest.fixture(scope="module")
def served() -> Iterator[tuple[Program, str]]:
    program = build_program(Config(robot="kinematic", map="square"), RealTime())
    routers, _ = plugged().features.routers(program)
    app = create_app(program, EngineThread(program.engine), Outlets(program), routers=routers)
    with listening(app) as address:
        yield program, address


@contextmanager
def asking(address: str) -> Iterator[None]:
    get(f"http://{address}")
    yield


LOOKERS: dict[str, Callable[[str], AbstractContextManager[object]]] = {
    "live": lambda address: connect(f"ws://{address}/api/live", max_queue=None),
    "camera": lambda address: connect(f"ws://{address}/api/camera", max_queue=None),
    "3D view": lambda address: connect(
        f"ws://{address}/view", subprotocols=[PROTOCOL], max_size=None, max_queue=None
    ),
    "motion JPEG": lambda address: stream("GET", f"http://{address}/camera.mjpg"),
    "picture": lambda address: asking(f"{address}/camera.jpg"),
    "state": lambda address: asking(f"{address}/api/state"),
    "ray": lambda address: asking(f"{address}/api/ray/45"),
    "particle": lambda address: asking(f"{address}/api/pose_fit?x=0&y=0"),
}


def rate(program: Program, wanted: Callable[[float], bool]) -> float:
    """Pictures a second of the robot's time, once they are as wanted, or after some seconds."""
    begun = newest(program).stamp
    while True:
        start, stamps = newest(program).stamp, set()
        while newest(program).stamp < start + WINDOW_S:
            stamps.add(newest(program).filter.line_scan.scan.stamp)
            time.sleep(0.01)
        found = len(stamps) / WINDOW_S
        if wanted(found) or newest(program).stamp > begun + RESTS_S:
            return found


def newest(program: Program) -> Snapshot:
    """The newest tick that has a scan."""
    while (shown := program.engine.latest.get()) is None or shown.filter.line_scan is None:
        time.sleep(0.01)
    return shown


@pytest.mark.parametrize("name", LOOKERS)
def test_whoever_looks_wakes_the_camera_and_it_rests_again(served, name: str) -> None:
    """Who wants each tick sees all pictures; others every third, as the robot stands."""
    program, address = served
    least = 20 if name == "live" else 0.8 / WATCHED_PERIOD
    assert rate(program, lambda hz: hz < 7) < 7
    with LOOKERS[name](address):
        assert rate(program, lambda hz: hz > least) > least
    assert rate(program, lambda hz: hz < 7) < 7
