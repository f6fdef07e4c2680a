"""The server as its clients see it: a process of its own, real sockets."""

import struct
from itertools import pairwise

import cv2
import httpx
import numpy as np
import pytest
import websockets
from serving import ServedProgram, ask, telemetry
from websockets.sync.client import connect

from app.features.weighing.messages import ProfileMessage
from app.messages.answers import (
    FieldMessage,
    HealthMessage,
    ParameterMessage,
    ProblemsMessage,
)
from app.messages.telemetry import PictureMessage, TelemetryMessage
from app.settings.config import FRONTEND

pytestmark = pytest.mark.slow


def get(server: ServedProgram, path: str, **headers) -> httpx.Response:
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


@pytest.mark.parametrize("path", ["/api/field", "/api/parameters"])
def test_long_answers_are_compressed_for_those_who_take_it(server, path):
    plain = get(server, path, **{"Accept-Encoding": "identity"})
    small = get(server, path, **{"Accept-Encoding": "gzip"})
    assert "Content-Encoding" not in plain.headers and small.headers["Content-Encoding"] == "gzip"
    assert plain.headers["Vary"] == small.headers["Vary"] == "Accept-Encoding"
    assert small.json() == plain.json()
    assert int(small.headers["Content-Length"]) == small.num_bytes_downloaded
    assert small.num_bytes_downloaded < 0.4 * len(plain.content)


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


@pytest.mark.parametrize(
    "path", ["/", "/lens", "/static/main.js", "/view/", "/docs", "/openapi.json"]
)
def test_pages_are_there(server, path):
    assert get(server, path).status_code == 200


@pytest.mark.parametrize(
    ("path", "status"),
    [
        ("/", 200),
        ("/static/main.js", 200),
        ("/static/index.html", 404),
        ("/view/", 200),
        ("/docs", 200),
        ("/api/state", 200),
        ("/api/camera.jpg", 404),
        ("/nothing", 404),
    ],
)
def test_no_answer_may_be_framed_by_other_pages(server, path, status):
    answer = get(server, path)
    assert answer.status_code == status
    assert answer.headers["Content-Security-Policy"] == "frame-ancestors 'self'"
    assert answer.headers["X-Content-Type-Options"] == "nosniff"


def test_a_refusal_may_not_be_framed_either(server):
    answer = get(server, "/", Origin="http://elsewhere.example")
    assert answer.status_code == 403
    assert answer.headers["Content-Security-Policy"] == "frame-ancestors 'self'"


def test_the_3d_page_is_not_sent_twice(server):
    tag = get(server, "/view/").headers["etag"]
    assert get(server, "/view/", **{"If-None-Match": tag}).status_code == 304


def test_a_file_of_the_page_comes_whole_and_in_parts_and_is_not_sent_again(server):
    path, content = "/static/main.js", (FRONTEND / "main.js").read_bytes()
    whole = get(server, path)
    assert (whole.status_code, whole.content) == (200, content)
    assert whole.headers["content-encoding"] == "gzip"
    assert int(whole.headers["content-length"]) < len(content) / 2
    plain = get(server, path, **{"Accept-Encoding": "identity"})
    assert (plain.headers["content-length"], plain.content) == (str(len(content)), content)
    assert "javascript" in whole.headers["content-type"]
    part = get(server, path, Range="bytes=10-19")
    assert (part.status_code, part.content) == (206, content[10:20])
    again = get(server, path, **{"If-None-Match": whole.headers["etag"]})
    assert (again.status_code, again.content) == (304, b"")
    for answer in (whole, part, again):
        assert answer.headers["cache-control"] == "no-cache"
    head = httpx.head(server.url + path, timeout=20, trust_env=False)
    assert (head.headers["content-length"], head.content) == (str(len(content)), b"")


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
        # A page at another port of this machine.
        {"Sec-Fetch-Site": "same-site", "Sec-Fetch-Mode": "no-cors"},
        {"Host": "[::1"},
        {"Origin": "http://evil.example"},
        {"Origin": "http://[::1"},
        {"Origin": "null"},
        {"Origin": ""},
    ],
)
def test_other_origins_and_names_are_refused(server, headers):
    assert get(server, "/api/state", **headers).status_code == 403


def test_a_page_at_another_port_is_of_another_origin(server):
    """Also where its address is the beginning of the robot's."""
    for origin in (server.url[:-1], server.url + "0", server.url.rpartition(":")[0]):
        assert get(server, "/api/state", Origin=origin).status_code == 403


@pytest.mark.parametrize("path", ["/api/live", "/api/camera", "/view"])
def test_other_origins_get_no_socket(server, path):
    with pytest.raises(websockets.InvalidStatus) as refused:
        connect(f"ws://{server.address}{path}", origin="http://evil.example")
    assert refused.value.response.status_code == 403


def test_our_own_page_gets_one(server):
    with connect(f"ws://{server.address}/api/live", origin=server.url, max_size=None) as socket:
        assert telemetry(socket)


# --- pictures and 3D over sockets ------------------------------------------------------------


def parts(message: bytes) -> tuple[PictureMessage, np.ndarray]:
    (length,) = struct.unpack("<I", message[:4])
    head, jpeg = message[4 : 4 + length], message[4 + length :]
    grey = cv2.imdecode(np.frombuffer(jpeg, np.uint8), cv2.IMREAD_GRAYSCALE)
    return PictureMessage.model_validate_json(head), grey


def test_camera_socket_sends_each_picture_with_its_own_scan(server, live):
    found = []
    with connect(f"ws://{server.address}/api/camera", max_size=None) as camera:
        for _ in range(25):
            ask(live, type="drive", v=0.1, omega=2.0)
            found.append(parts(camera.recv(timeout=20)))
    ask(live, type="stop")
    assert all(later.stamp > earlier.stamp for (earlier, _), (later, _) in pairwise(found))
    for picture, grey in found:
        rays = zip(picture.edges.entry_px, picture.edges.exit_px, strict=True)
        edges = np.array([pair for pair in rays if None not in pair])
        entry, way = edges[:, 0], edges[:, 1] - edges[:, 0]
        (u, v), (before_u, before_v) = (
            np.rint(entry + share * way).astype(int).T for share in (0.25, -0.25)
        )
        # A fast turn moves the edges by many pixels from picture to picture.
        assert np.mean(grey[v, u] + 60.0 < grey[before_v, before_u]) > 0.9
    assert abs(telemetry(live)["scan"]["stamp"] - picture.stamp) < 0.5


def test_the_3d_socket_is_handed_on_with_its_subprotocol(server):
    import viser

    name = websockets.Subprotocol(f"viser-v{viser.__version__}")
    with connect(f"ws://{server.address}/view", subprotocols=[name], max_size=None) as view:
        assert view.subprotocol == name
        assert len(view.recv(timeout=20)) > 100
