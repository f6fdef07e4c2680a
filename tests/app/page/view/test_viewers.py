"""Viewers of the 3D view: viser serves them by our websocket."""

from __future__ import annotations

import pytest
import viser
from apps import listening
from httpx import get
from serving import until
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import ClientConnection, connect

from app.engine.build import build_program
from app.engine.engine_thread import EngineThread
from app.page.outlets import Outlets
from app.page.server import create_app
from app.page.view.cameras import Cameras
from app.page.view.scene import Scene
from app.page.view.view import View
from app.page.view.viewers import PROTOCOL
from app.settings.config import Config
from sim.real_time import RealTime

pytestmark = pytest.mark.slow


def view(server, *protocols: str) -> ClientConnection:
    return connect(f"ws://{server.address}/view", subprotocols=protocols or None, max_size=None)


def closed(socket: ClientConnection) -> tuple[int | None, str | None]:
    """The close frame that comes after all that came before."""
    with pytest.raises(ConnectionClosed) as ended:
        while True:
            socket.recv(timeout=20)
    assert ended.value.rcvd is not None, "no close frame"
    return ended.value.rcvd.code, ended.value.rcvd.reason


@pytest.mark.parametrize("protocols", [(), ("viser-v0.0.1",), ("foxglove.sdk.v1", "chat")])
def test_another_version_is_told_by_a_close_frame(server, protocols) -> None:
    with view(server, *protocols) as socket:
        code, reason = closed(socket)
    assert code == 1002
    assert viser.__version__ in reason


@pytest.mark.parametrize("nonsense", ["a text", b"", b"\x00garbage", b"\x93"])
def test_who_sends_nonsense_is_closed_and_the_others_go_on(server, nonsense) -> None:
    with view(server, PROTOCOL) as other, view(server, PROTOCOL) as socket:
        assert len(socket.recv(timeout=20)) > 100
        socket.send(nonsense)
        assert closed(socket)[0] == 1003
        other.recv(timeout=20)
        for _ in range(20):
            assert other.recv(timeout=20)


def test_a_viewer_that_has_gone_leaves_nothing_open(server, live) -> None:
    before = server.descriptors()
    for _ in range(20):
        with view(server, PROTOCOL) as socket:
            socket.recv(timeout=20)
    until(live, lambda now: server.descriptors() <= before)


def test_a_page_that_has_gone_has_no_camera(monkeypatch) -> None:
    made: list[Cameras] = []
    begin = Cameras.__init__

    def noted(self: Cameras, *given: object) -> None:
        made.append(self)
        begin(self, *given)  # type: ignore[arg-type]

    monkeypatch.setattr(Cameras, "__init__", noted)
    program = build_program(Config(robot="kinematic", map="square"), RealTime())
    app = create_app(program, EngineThread(program.engine), Outlets(program))
    with listening(app) as address:
        with connect(f"ws://{address}/view/mine", subprotocols=[PROTOCOL], max_size=None) as socket:
            socket.recv(timeout=20)
            [cameras] = made
            assert list(cameras._clients) == ["mine"]
        for _ in range(500):
            if not cameras._clients:
                break
            get(f"http://{address}/api/health")
        assert not cameras._clients


def test_nothing_is_drawn_for_nobody_but_paths_are_kept(monkeypatch) -> None:
    done: list[str] = []

    def note(kind: type, name: str) -> None:
        original = getattr(kind, name)

        def noted(self: object, *given: object) -> None:
            done.append(name)
            original(self, *given)

        monkeypatch.setattr(kind, name, noted)

    note(Scene, "__init__")
    note(Scene, "update")
    note(View, "_remember")

    def more_of(name: str, address: str) -> list[str]:
        """What is done until something is done three times."""
        begin = len(done)
        for _ in range(2000):
            if done[begin:].count(name) >= 3:
                break
            get(f"http://{address}/api/health")
        return done[begin:]

    program = build_program(Config(robot="kinematic", map="square"), RealTime())
    app = create_app(program, EngineThread(program.engine), Outlets(program))
    with listening(app) as address:
        more_of("_remember", address)
        assert set(done) == {"_remember"}
        with connect(f"ws://{address}/view/mine", subprotocols=[PROTOCOL], max_size=None):
            assert more_of("update", address).count("update") >= 3
        # With each update they are kept as well: those alone are for nobody.
        assert any("update" not in more_of("_remember", address) for _ in range(50))
        with connect(f"ws://{address}/view/mine", subprotocols=[PROTOCOL], max_size=None):
            more_of("update", address)
        assert done.count("__init__") == 1
