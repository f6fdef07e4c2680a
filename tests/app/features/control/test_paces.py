"""How many ticks come from control to the server, and from there to a page, as each asks for."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
import pytest
from apps import listening
from camera_sources import until
from websockets.sync.client import connect

from app.engine.engine_thread import EngineThread
from app.engine.rest import WATCHED_PERIOD
from app.features.control.remote import RemoteProgram
from app.page.outlets import Outlets
from app.page.server import create_app
from app.page.serving import build_served
from app.settings.config import Config, with_settings
from robot.localization.parameters import LocalizationParameters
from sim.floor_camera import CameraSettings
from sim.simulated import SimSettings

pytestmark = pytest.mark.slow

PICTURES_HZ, TICKS_HZ = 5.0, 50.0
TICKS = 30


@contextmanager
def serving(config: Config) -> Iterator[tuple[RemoteProgram, str]]:
    """A program whose robot another process drives, with its page."""
    program = build_served(config)
    assert isinstance(program, RemoteProgram)
    with listening(create_app(program, EngineThread(program.engine), Outlets(program))) as address:
        yield program, address


@pytest.fixture(scope="module")
def served() -> Iterator[tuple[RemoteProgram, str]]:
    """One whose robot never rests, as its filter learns while it stands."""
    sim = SimSettings(camera=CameraSettings(frame_rate=PICTURES_HZ))
    learns = with_settings(LocalizationParameters(), {"filter.update_min_d": 0.0})
    config = Config(robot="kinematic", map="stub", sim=sim, localization=learns)
    with serving(config) as made:
        yield made


def received(address: str, query: str = "") -> list[float]:
    """Stamps of the telemetry of a page that takes what it gets [s]."""
    stamps: list[float] = []
    with connect(f"ws://{address}/api/live{query}", max_size=None, max_queue=None) as socket:
        while len(stamps) < TICKS + 10:
            message = json.loads(socket.recv(timeout=30))
            if message["type"] == "telemetry":
                stamps.append(message["stamp"])
    return stamps[10:]


def hz(stamps: list[float]) -> float:
    return (len(stamps) - 1) / (stamps[-1] - stamps[0])


@pytest.mark.parametrize("wanted", [10.0, 30.0])
def test_a_page_gets_as_many_ticks_as_it_asks_for(served, wanted: float) -> None:
    _, address = served
    # Never more; less where the machine is busy, but each is a tick of its own.
    rates = [hz(received(address, f"?rate={wanted:g}")) for _ in range(3)]
    assert max(rates) <= 1.1 * wanted
    assert max(rates) > 0.7 * wanted


def test_who_says_no_rate_gets_each_tick(served) -> None:
    _, address = served
    assert max(hz(received(address)) for _ in range(3)) > 0.7 * TICKS_HZ


def test_a_page_gets_no_more_of_a_robot_that_rests_than_there_are_pictures() -> None:
    with serving(Config(robot="kinematic", map="stub")) as (_, address):
        received(address, "?rate=30")  # meanwhile it comes to rest
        assert hz(received(address, "?rate=30")) == pytest.approx(1 / WATCHED_PERIOD, rel=0.1)
        assert max(hz(received(address)) for _ in range(3)) > 0.7 * TICKS_HZ


def test_control_sends_what_is_asked_for_and_the_pictures(served) -> None:
    program, _ = served
    engine = program.engine

    def arrived() -> list[float]:
        stamps: list[float] = []

        def more() -> bool:
            stamp = engine.latest.get().stamp
            if not stamps or stamp > stamps[-1]:
                stamps.append(stamp)
            return len(stamps) > TICKS

        until(more)
        return stamps[5:]

    with engine.audience.joined(10.0):
        few = hz(arrived())
        with engine.audience.joined(30.0):
            assert hz(arrived()) > 1.3 * few
    assert few <= 10.0 + PICTURES_HZ + 1.5
    assert np.median(np.diff(arrived())) > 0.1
