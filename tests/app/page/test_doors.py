"""A program with tokens lets nobody in without one, by any of its doors."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import closing

import httpx
import pytest
from serving import ServedProgram, ask, until
from serving import server as started
from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect

from app.features.recordings.remote_robot import RemoteRobot, RemoteRobotError
from app.features.ros.foxglove.protocol import SUBPROTOCOLS
from app.page.token_guard import SUBPROTOCOL
from benchmarks.programs import START_S, estimated

pytestmark = pytest.mark.slow

PAGES = (
    "/", "/static/main.js", "/docs", "/openapi.json", "/view/", "/camera.jpg", "/camera.mjpg",
    "/api/access", "/api/health", "/api/state", "/api/field", "/api/field.png", "/api/parameters",
    "/api/problems", "/api/recordings", "/api/recordings/none", "/api/recording_contents",
    "/lens", "/api/lens", "/api/lens/camera.yaml", "/api/lens/profile.toml", "/api/board.pdf",
    "/api/floor-grid",
)  # fmt: skip
SOCKETS = ("/", "/rosbridge", "/foxglove", "/api/live", "/api/camera", "/api/lens", "/view")
REFUSED = 401


@pytest.fixture(scope="module")
def server() -> Iterator[ServedProgram]:
    arguments = ["--token", "drive-me", "--watch-token", "watch-me", "--foxglove"]
    with started("--robot", "kinematic", "--map", "stub", *arguments) as running:
        with socket_at(running, "/api/live", "drive-me") as socket:
            until(socket, estimated, START_S)
        yield running


def socket_at(server: ServedProgram, path: str, token: str = ""):
    headers = {"Authorization": f"Bearer {token}"} if token else {}
    return connect(server.url.replace("http", "ws") + path, additional_headers=headers)


@pytest.mark.parametrize("path", PAGES)
def test_no_page_is_told_to_a_stranger(server, path) -> None:
    assert httpx.get(f"{server.url}{path}").status_code == REFUSED
    assert httpx.get(f"{server.url}{path}?token=guess-1").status_code == REFUSED


def test_each_address_of_the_interface_asks_for_a_token_and_changes_for_those_who_drive(server):
    """Also those that somebody adds: the program's own description names them."""
    drives, watches = ({"Authorization": f"Bearer {word}-me"} for word in ("drive", "watch"))
    paths = httpx.get(f"{server.url}/openapi.json", headers=drives).json()["paths"]
    changing = [(path, way) for path, ways in paths.items() for way in ways if way != "get"]
    assert {way for _, way in changing} >= {"put", "patch", "delete"}
    for path, ways in paths.items():
        for way in ways:
            assert httpx.request(way, server.url + path).status_code == REFUSED
    for path, way in changing:
        if path.startswith("/api/view/"):
            continue  # a page's own view, which is nothing of the robot's
        answer = httpx.request(way, server.url + path, headers=watches)
        assert (answer.status_code, answer.text) == (403, "This token only watches.")


def test_a_page_of_another_site_changes_no_recording(server):
    headers = {"Authorization": "Bearer drive-me", "Origin": "http://elsewhere.example"}
    for way in ("put", "patch", "delete"):
        answer = httpx.request(way, f"{server.url}/api/recordings/first", headers=headers)
        assert (answer.status_code, "may not talk to" in answer.text) == (403, True)


@pytest.mark.parametrize("path", SOCKETS)
def test_no_socket_is_opened_to_a_stranger(server, path) -> None:
    with pytest.raises(InvalidStatus) as refused, socket_at(server, path):
        pass
    assert refused.value.response.status_code == REFUSED


def test_who_only_watches_sees_and_does_not_drive(server) -> None:
    with socket_at(server, "/api/live", "watch-me") as socket:
        assert ask(socket, type="ping")["type"] == "ack"
        for command in ({"type": "drive", "v": 0.1, "omega": 0}, {"type": "stop"}):
            answer = ask(socket, **command)
            assert answer["message"] == "This link only watches; ask for the link to drive."


@pytest.mark.parametrize(
    "order",
    [
        {"op": "publish", "topic": "/cmd_vel", "msg": {"linear": {"x": 0.1}}},
        {"op": "call_service", "service": "/reinitialize_global_localization"},
    ],
    ids=["publish", "service"],
)
def test_who_only_watches_gives_no_orders_by_rosbridge_either(server, order) -> None:
    for token, refused in (("watch-me", True), ("drive-me", False)):
        with socket_at(server, "/rosbridge", token) as socket:
            socket.send(json.dumps({"op": "call_service", "service": "/rosapi/topics"}))
            assert json.loads(socket.recv(timeout=10))["result"]
            socket.send(json.dumps({"op": "set_level", "level": "error"}))
            socket.send(json.dumps(order))
            socket.send(
                json.dumps({"op": "call_service", "service": "/rosapi/topics", "id": "end"})
            )
            answers = []
            while not answers or answers[-1].get("id") != "end":
                answers.append(json.loads(socket.recv(timeout=10)))
            assert any("only watches" in json.dumps(answer) for answer in answers) == refused


@pytest.mark.parametrize(
    ("token", "words"),
    [("watch-me", "this token only watches"), ("drive-me", "foxglove_commands = true")],
)
def test_foxglove_is_told_by_its_token_why_it_gives_no_orders(server, token, words) -> None:
    address = f"{server.url.replace('http', 'ws')}/foxglove?token={token}"
    with connect(address, subprotocols=[SUBPROTOCOLS[0]], max_size=None) as socket:
        socket.send(json.dumps({"op": "advertise", "channels": []}))
        told = {"message": ""}
        while told.get("op") != "status":
            told = json.loads(socket.recv(timeout=20))
        assert words in told["message"]


def test_a_socket_of_a_page_brings_its_token_as_a_subprotocol(server) -> None:
    address = server.url.replace("http", "ws") + "/api/live"
    with connect(address, subprotocols=[f"{SUBPROTOCOL}drive-me"]) as socket:
        assert ask(socket, type="stop")["type"] == "ack"


def test_a_robot_with_tokens_is_recorded_by_its_link_alone(server) -> None:
    with pytest.raises(RemoteRobotError, match="401"):
        RemoteRobot(server.url)
    with closing(RemoteRobot(f"{server.url}/?token=watch-me")) as robot:
        assert "/scan" in robot.topics()
        assert robot.contents().facts
