"""rosbridge as its own client libraries see it: a running program, real sockets."""

import json
import subprocess
import sys
from itertools import pairwise

import pytest
import websockets
from node_peers import needs_node, run_node
from places import HELPERS
from serving import serving, telemetry, until
from websockets.sync.client import connect

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def lines_of_roslibjs(server):
    return run_node("roslib_client.mjs", f"ws://{server.address}/rosbridge")


@pytest.fixture
def told_by_roslibjs(lines_of_roslibjs):
    return merged(lines_of_roslibjs)


def merged(lines) -> dict:
    return {name: value for line in lines for name, value in line.items()}


@needs_node
def test_roslibjs_finds_topics_and_services(told_by_roslibjs):
    told = told_by_roslibjs
    topics = dict(zip(told["topics"]["topics"], told["topics"]["types"], strict=True))
    assert topics["/odom"] == "nav_msgs/msg/Odometry"
    assert told["scans"] == ["/scan"]
    assert "/set_initial_pose" in told["services"]
    assert told["nodes"] == ["/brickpose"]
    assert told["twist"]["twist"]["linear"] == {"x": "float64", "y": "float64", "z": "float64"}


@needs_node
def test_roslibjs_reads_every_compression(lines_of_roslibjs):
    lines = lines_of_roslibjs
    by_compression = {one["compression"]: one for one in lines if "compression" in one}
    kinds = {name: one["kind"] for name, one in by_compression.items()}
    assert kinds == {"none": "Array", "cbor": "Float64Array", "png": "Array"}
    for one in by_compression.values():
        assert one["frame"] == "odom"
        assert len(one["covariance"]) == 36
    assert by_compression["none"]["covariance"][0] > 0
    told = merged(lines)
    assert told["picture"] == [0xFF, 0xD8]
    maps = [one for one in lines if "map" in one]
    assert len(maps) == 2
    described = [{**one["map"], "map_load_time": None} for one in maps]
    assert {**maps[0], "map": described[0]} == {**maps[1], "map": described[1]}
    assert maps[0]["cells"] == maps[0]["map"]["width"] * maps[0]["map"]["height"]
    assert maps[0]["occupied"] > 0
    assert told["scan"]["header"]["frame_id"] == "base_scan"


@needs_node
def test_roslibjs_is_throttled_as_it_asked(told_by_roslibjs):
    assert min(told_by_roslibjs["throttled"]) > 0.15


@needs_node
def test_roslibjs_calls_services_and_is_told_why_not(told_by_roslibjs):
    told = told_by_roslibjs
    assert told["scatter"] == {"result": True, "values": {}}
    assert told["offMap"]["result"] is False
    assert "off the map" in told["offMap"]["words"]
    assert "/fly is no service; valid are" in told["noService"]["words"]


@needs_node
def test_roslibjs_drives_and_when_it_is_silent_the_robot_stops(told_by_roslibjs):
    assert told_by_roslibjs["stoppedAfter"] < 1.0
    assert "status" not in told_by_roslibjs


@pytest.fixture(scope="module")
def told_by_roslibpy(server):
    pytest.importorskip("roslibpy")
    script = HELPERS / "roslibpy_client.py"
    ended = subprocess.run(
        [sys.executable, str(script), f"ws://{server.address}/rosbridge"],
        capture_output=True,
        text=True,
        timeout=90,
        check=False,
    )
    assert ended.returncode == 0, ended.stderr[-2000:]
    told = merged(json.loads(line) for line in ended.stdout.splitlines())
    return told | {"complaints": ended.stderr}


def test_roslibpy_finds_and_reads_topics(told_by_roslibpy):
    told = told_by_roslibpy
    assert {"/scan", "/cmd_vel"} <= set(told["topics"])
    assert told["kind"] == "sensor_msgs/msg/LaserScan"
    assert "/rosapi/topics" in told["services"]
    assert told["ranges"] > 10
    assert told["frame"] == "base_scan"
    assert told["cells"] == told["info"]["width"] * told["info"]["height"]
    stamps = told["throttled"]
    assert all(later - earlier > 0.2 for earlier, later in pairwise(stamps))


def test_roslibpy_calls_services_and_drives(told_by_roslibpy):
    assert told_by_roslibpy["update"] == {}
    assert "poze is no field" in told_by_roslibpy["wrong"]
    assert told_by_roslibpy["stands"]


def test_a_refused_message_is_no_exception_in_roslibpy(told_by_roslibpy):
    assert told_by_roslibpy["after_refusal"] == {}
    assert told_by_roslibpy["complaints"] == ""


def bridge(server, **options):
    return connect(f"ws://{server.address}/rosbridge", max_size=None, **options)


def test_when_the_client_leaves_the_robot_stops(server, live):
    before = telemetry(live)
    with bridge(server) as socket:
        message = {"twist": {"linear": {"x": 0.1}}}
        request = json.dumps({"op": "publish", "topic": "/cmd_vel", "msg": message})
        socket.send(request)
        until(live, lambda now: now["stamp"] > before["stamp"] and now["twist"]["v"] > 0)
        socket.send(request)
    assert until(live, lambda now: now["twist"]["v"] == 0)


def test_a_page_of_another_site_is_not_let_in(server):
    with pytest.raises(websockets.InvalidStatus, match="403"):
        bridge(server, origin="https://evil.example")


def test_what_is_far_too_large_ends_that_client_only(server, live):
    with bridge(server) as hostile, pytest.raises(websockets.ConnectionClosed):
        hostile.send("x" * 3_000_000)
        while True:
            hostile.recv(timeout=20)
    assert telemetry(live)


def test_junk_is_answered_and_the_client_goes_on(server):
    with bridge(server) as socket:
        socket.send(json.dumps({"op": "set_level", "level": "error"}))
        for junk in (b"\x00\xff", "[" * 50_000, '{"op": "subscribe", "topic": "/wrong"}'):
            socket.send(junk)
            assert json.loads(socket.recv(timeout=20))["op"] == "status"
        socket.send(json.dumps({"op": "call_service", "service": "/rosapi/nodes", "id": 3}))
        assert json.loads(socket.recv(timeout=20))["values"] == {"nodes": ["/brickpose"]}


def test_a_page_of_another_place_is_let_in_where_a_setting_says_so(tmp_path):
    config = tmp_path / "lab.toml"
    config.write_text('allowed_origins = ["http://lab.example:5500/", "null"]', encoding="utf-8")
    with serving("--robot", "kinematic", "--map", "stub", "--config", str(config)) as running:
        for origin in ("http://lab.example:5500", "null"):
            with bridge(running, origin=origin) as socket:
                request = {"op": "call_service", "service": "/rosapi/nodes", "id": 1}
                socket.send(json.dumps(request))
                assert json.loads(socket.recv(timeout=20))["result"]
        for origin in ("http://lab.example", "https://lab.example:5500", "http://evil.example"):
            with pytest.raises(websockets.InvalidStatus, match="403"):
                bridge(running, origin=origin)
