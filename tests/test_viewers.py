"""Viewers of the 3D view: viser serves them by our websocket."""

from __future__ import annotations

import pytest
import viser
from serving import until
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import ClientConnection, connect

from app.page.view.viewers import PROTOCOL


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
