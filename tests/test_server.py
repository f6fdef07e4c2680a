"""The server as its clients see it: a process of its own, real sockets."""

import json
import re
import socket as sockets
import struct
from itertools import pairwise

import cv2
import httpx
import numpy as np
import pytest
import websockets
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from serving import Server, ask, serving, telemetry, until
from websockets.sync.client import connect

from app.messages.answers import (
    FieldMessage,
    HealthMessage,
    ParameterMessage,
    ProblemsMessage,
    ProfileMessage,
)
from app.messages.telemetry import TelemetryMessage


@pytest.fixture(scope="module")
def server():
    with serving("--robot", "kinematic", "--map", "stub") as running:
        yield running


@pytest.fixture
def live(server):
    with server.live() as socket:
        yield socket
        ask(socket, type="stop")


def get(server: Server, path: str, **headers) -> httpx.Response:
    return httpx.get(server.url + path, headers=headers, timeout=20, trust_env=False)


# --- HTTP ------------------------------------------------------------------------------------


def test_health_is_ok(server):
    health = HealthMessage.model_validate_json(get(server, "/api/health").text)
    assert (health.status, health.robot) == ("ok", "Kinematic robot")
    assert health.uptime_s > 0


def test_state_is_the_newest_telemetry(server):
    first = TelemetryMessage.model_validate_json(get(server, "/api/state").text)
    second = TelemetryMessage.model_validate_json(get(server, "/api/state").text)
    assert first.map == "stub"
    assert second.stamp >= first.stamp
    assert len(first.estimate.covariance) == 9
    assert first.robot.can_be_placed


def test_field_and_its_picture_agree(server):
    field = FieldMessage.model_validate_json(get(server, "/api/field").text)
    picture = cv2.imdecode(
        np.frombuffer(get(server, "/api/field.png").content, np.uint8), cv2.IMREAD_GRAYSCALE
    )
    xmin, ymin, xmax, ymax = field.extent
    height, width = picture.shape
    assert width / height == pytest.approx((xmax - xmin) / (ymax - ymin), rel=1e-3)
    assert len(field.rays_px) == 91


def test_camera_picture_is_a_jpeg_of_the_cameras_size(server):
    answer = get(server, "/camera.jpg")
    assert answer.headers["content-type"] == "image/jpeg"
    picture = cv2.imdecode(np.frombuffer(answer.content, np.uint8), cv2.IMREAD_UNCHANGED)
    assert picture.shape[:2] == (480, 640)


def test_motion_jpeg_goes_on(server):
    with httpx.stream("GET", server.url + "/camera.mjpg", timeout=20, trust_env=False) as answer:
        assert answer.headers["content-type"].startswith("multipart/x-mixed-replace")
        seen = b""
        for part in answer.iter_bytes():
            seen += part
            if seen.count(b"\xff\xd8\xff") >= 3:
                break
    assert seen.count(b"--frame") >= 3


def test_parameters_have_meanings_and_ranges(server):
    found = [ParameterMessage.model_validate(p) for p in get(server, "/api/parameters").json()]
    names = [parameter.name for parameter in found]
    assert {"alpha1", "sigma_hit", "min_particles", "laser_model_type"} <= set(names)
    assert all(parameter.meaning for parameter in found)


def test_a_ray_tells_why_it_counted(server):
    found = [
        ProfileMessage.model_validate_json(get(server, f"/api/ray/{ray}").text)
        for ray in range(0, 91, 10)
    ]
    counted = [profile for profile in found if profile.counted]
    assert len(counted) >= 4
    for profile in counted:
        assert len(profile.distances) == len(profile.grey) == len(profile.response) > 100
        assert profile.width == pytest.approx(0.05, abs=0.005)
        assert profile.distances[0] < profile.entry < profile.exit
    missing = get(server, "/api/ray/91")
    assert missing.status_code == 404
    assert "valid is 0 to 90" in missing.text
    assert get(server, "/api/ray/x").status_code == 422


def test_the_record_of_problems_can_be_read(server):
    ProblemsMessage.model_validate_json(get(server, "/api/problems").text)


@pytest.mark.parametrize("path", ["/", "/static/main.js", "/view/", "/docs", "/openapi.json"])
def test_pages_are_there(server, path):
    assert get(server, path).status_code == 200


def test_other_pages_cannot_hold_it_in_a_frame(server):
    assert get(server, "/").headers["Content-Security-Policy"] == "frame-ancestors 'self'"


def test_the_3d_page_is_not_sent_twice(server):
    tag = get(server, "/view/").headers["etag"]
    assert get(server, "/view/", **{"If-None-Match": tag}).status_code == 304


@pytest.mark.parametrize(
    "path", ["/nothing", "/static/../pyproject.toml", "/static/%2e%2e/README.md"]
)
def test_nothing_else_is_served(server, path):
    assert get(server, path).status_code == 404


# --- who may ---------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "headers",
    [
        {"Host": "evil.example"},
        {"Sec-Fetch-Site": "cross-site", "Sec-Fetch-Mode": "no-cors"},
        {"Host": "[::1"},
        {"Origin": "http://evil.example"},
        {"Origin": "http://[::1"},
        {"Origin": "null"},
        {"Origin": ""},
    ],
)
def test_other_origins_and_names_are_refused(server, headers):
    assert get(server, "/api/state", **headers).status_code == 403


@pytest.mark.parametrize("path", ["/api/live", "/api/camera", "/view"])
def test_other_origins_get_no_socket(server, path):
    with pytest.raises(websockets.InvalidStatus) as refused:
        connect(f"ws://{server.address}{path}", origin="http://evil.example")
    assert refused.value.response.status_code == 403


def test_our_own_page_gets_one(server):
    with connect(f"ws://{server.address}/api/live", origin=server.url, max_size=None) as socket:
        assert telemetry(socket)


# --- telemetry and commands ------------------------------------------------------------------


def test_telemetry_comes_newest_first_and_is_valid(live):
    stamps = [TelemetryMessage.model_validate(telemetry(live)).stamp for _ in range(20)]
    assert all(later > earlier for earlier, later in pairwise(stamps))


def test_drive_is_answered_and_moves_the_robot(live):
    start = telemetry(live)
    assert ask(live, type="drive", v=0.2, omega=0, id=7) == pytest.approx(
        {"type": "ack", "id": 7, "stamp": start["stamp"]}, abs=1.0
    )
    moved = until(live, lambda t: abs(t["truth"]["x"] - start["truth"]["x"]) > 0.02)
    assert moved["twist"]["v"] > 0.05


def test_without_renewal_it_stops_after_half_a_second(live):
    ask(live, type="drive", v=0.2, omega=0.5)
    moving = until(live, lambda t: t["twist"]["v"] > 0)
    still = until(live, lambda t: t["twist"]["v"] == 0)
    assert still["stamp"] - moving["stamp"] <= 0.52


def test_when_the_driver_leaves_it_stops_at_once(server, live):
    with server.live() as driver:
        for _ in range(5):
            ask(driver, type="drive", v=0.2, omega=0)
        until(live, lambda t: t["twist"]["v"] > 0)
        ask(driver, type="drive", v=0.2, omega=0)
        left = telemetry(live)["stamp"]
    still = until(live, lambda t: t["twist"]["v"] == 0)
    assert still["stamp"] - left < 0.3


def test_a_viewer_that_does_not_drive_may_leave(server, live):
    ask(live, type="drive", v=0.1, omega=0)
    with server.live() as other:
        telemetry(other)
    assert telemetry(live)["twist"]["v"] > 0


def test_one_of_two_drivers_may_leave(server, live):
    with server.live() as other:
        ask(other, type="figure_eight")
        ask(live, type="figure_eight")
    assert {telemetry(live)["mode"] for _ in range(10)} == {"figure_eight"}


def test_set_pose_and_place(live):
    ask(live, type="place", x=0.1, y=0.1, theta=1.0)
    placed = until(live, lambda t: abs(t["truth"]["x"] - 0.1) < 1e-6)
    assert placed["truth"]["theta"] == pytest.approx(1.0)
    ask(live, type="set_pose", x=0.1, y=0.1, theta=1.0, sd_xy=0.005, sd_theta=0.02)
    near = until(live, lambda t: t["estimate"] and abs(t["estimate"]["theta"] - 1.0) < 0.1)
    assert near["estimate"]["x"] == pytest.approx(0.1, abs=0.02)
    assert near["estimate"]["y"] == pytest.approx(0.1, abs=0.02)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("", "JSON"),
        ("{", "JSON"),
        ("[]", ""),
        ("null", ""),
        ('{"type": "fly", "id": 3}', "'drive'"),
        ('{"id": 3}', "type"),
        ('{"type": "drive", "v": 1}', "omega"),
        ('{"type": "drive", "v": NaN, "omega": 0}', "finite"),
        ('{"type": "drive", "v": 1e999, "omega": 0}', "finite"),
        ('{"type": "drive", "v": "fast", "omega": 0}', "v"),
        ('{"type": "drive", "v": true, "omega": 0}', "v: .*number"),
        ('{"type": "drive", "v": "1", "omega": 0}', "v: .*number"),
        ('{"type": "drive", "v": 1, "omega": 0, "speed": 3}', "speed"),
        ('{"type": "stop", "id": "\\ud800"}', "JSON"),
        ('{"type": "set_pose", "x": 5, "y": 0, "theta": 0}', "off the map"),
        ('{"type": "set_pose", "x": 0, "y": 0, "theta": 0, "sd_xy": -1}', "sd_xy"),
        ('{"type": "place", "x": 0, "y": -9, "theta": 0}', "off the map"),
        ('{"type": "set_parameters", "values": {"sigma": 1}}', "valid are .*sigma_hit"),
        ('{"type": "set_parameters", "values": {"sigma_hit": 9}}', "valid is 0.0005 to 0.5"),
        ('{"type": "set_parameters", "values": {"min_particles": 1.5}}', "int"),
        ('{"type": "set_parameters", "values": {}}', "values"),
        ('{"type": "show", "layer": "ghosts", "visible": true}', "layer"),
        ("[" * 5000, ""),
        ('{"type": "stop", "id": "' + "x" * 70_000 + '"}', "at most"),
    ],
)
def test_a_wrong_command_is_refused_with_what_is_valid(live, text, told):
    live.send(text)
    assert re.search(told, until_error(live))
    assert telemetry(live)


def test_a_refused_command_keeps_its_id(live):
    assert ask(live, type="fly", id="abc")["id"] == "abc"


def test_a_binary_message_is_refused(live):
    live.send(b"\x00\xff")
    assert until_error(live)
    assert telemetry(live)


def until_error(live) -> str:
    while True:
        message = json.loads(live.recv(timeout=20))
        if message["type"] == "error":
            return message["message"]


SCALARS = st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5)
COMMANDS = st.dictionaries(
    st.sampled_from(["v", "omega", "x", "y", "theta", "values", "id"]), SCALARS
).flatmap(
    lambda rest: st.sampled_from(["drive", "set_pose", "place", "set_parameters", "show"]).map(
        lambda kind: json.dumps({"type": kind, **rest})
    )
)


@settings(max_examples=80, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.text(max_size=50) | COMMANDS | st.lists(SCALARS).map(json.dumps))
def test_whatever_is_sent_is_answered(live, text):
    live.send(text)
    while json.loads(live.recv(timeout=20))["type"] not in ("ack", "error"):
        pass


def test_a_message_that_is_far_too_large_ends_that_viewer_only(server, live):
    with server.live() as hostile, pytest.raises(websockets.ConnectionClosed):
        hostile.send("x" * 3_000_000)
        while True:
            hostile.recv(timeout=20)
    assert telemetry(live)


def test_a_viewer_that_stops_reading_holds_nobody_up(server, live):
    stuck = sockets.create_connection(tuple(server.address.split(":")))
    stuck.setsockopt(sockets.SOL_SOCKET, sockets.SO_RCVBUF, 4096)
    key = "GET /api/live HTTP/1.1\r\nHost: {}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
    stuck.sendall(
        (key + "Sec-WebSocket-Key: MDEyMzQ1Njc4OWFiY2RlZg==\r\nSec-WebSocket-Version: 13\r\n\r\n")
        .format(server.address)
        .encode()
    )
    first = telemetry(live)
    last = until(live, lambda t: t["stamp"] > first["stamp"] + 3)
    assert last["loop"]["step_hz"] > 40
    stuck.close()


# --- pictures and 3D over sockets ------------------------------------------------------------


def test_camera_socket_sends_stamp_and_jpeg(server, live):
    with connect(f"ws://{server.address}/api/camera", max_size=None) as camera:
        messages = [camera.recv(timeout=20) for _ in range(5)]
    stamps = [struct.unpack("<d", message[:8])[0] for message in messages]
    assert all(later > earlier for earlier, later in pairwise(stamps))
    assert all(message[8:11] == b"\xff\xd8\xff" for message in messages)
    assert abs(telemetry(live)["scan"]["stamp"] - stamps[-1]) < 0.5


def test_the_3d_socket_is_handed_on_with_its_subprotocol(server):
    import viser

    name = websockets.Subprotocol(f"viser-v{viser.__version__}")
    with connect(f"ws://{server.address}/view", subprotocols=[name], max_size=None) as view:
        assert view.subprotocol == name
        assert len(view.recv(timeout=20)) > 100
