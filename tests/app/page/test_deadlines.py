"""Deadlines: what a running server has to do in time, by the clock on the wall or close to it."""

import json
import socket as sockets
import time

import pytest
from serving import ask, serving, stamp_now, telemetry, until
from websockets.sync.client import connect

from app.features.recordings.files.mcap_reader import open_recording

pytestmark = pytest.mark.real_time


def test_without_renewal_it_stops_within_half_a_second(live):
    ask(live, type="drive", v=0.2, omega=0.5)
    moving = until(live, lambda t: t["twist"]["v"] > 0)
    still = until(live, lambda t: t["twist"]["v"] == 0)
    assert still["stamp"] - moving["stamp"] <= 0.4


def test_when_the_driver_leaves_it_stops_at_once(server, live):
    with server.live() as driver:
        for _ in range(5):
            ask(driver, type="drive", v=0.2, omega=0)
        until(live, lambda t: t["twist"]["v"] > 0)
        ask(driver, type="drive", v=0.2, omega=0)
    left = stamp_now(server)
    still = until(live, lambda t: t["twist"]["v"] == 0)
    assert still["stamp"] - left < 0.3


def test_a_viewer_that_does_not_drive_may_leave(server, live):
    ask(live, type="drive", v=0.1, omega=0)
    moving = until(live, lambda t: t["twist"]["v"] > 0)
    with server.live() as other:
        telemetry(other)
    still = until(live, lambda t: t["twist"]["v"] == 0)
    # It goes on until its own command ends.
    assert still["stamp"] - moving["stamp"] > 0.25


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


def test_a_client_that_reads_nothing_holds_nobody_up(server, live):
    address = f"ws://{server.address}/rosbridge"
    with connect(address, max_size=None, close_timeout=0.1) as stuck:
        # Nothing is read below: its queue of received messages is full after a few.
        for name in ("/odom", "/camera/image/compressed", "/map"):
            wish = {"topic": name, "queue_length": 10_000, "every": True}
            stuck.send(json.dumps({"op": "subscribe", **wish}))
        first = telemetry(live)
        last = until(live, lambda now: now["stamp"] > first["stamp"] + 2)
        assert last["loop"]["step_hz"] > 30
        assert ask(live, type="ping")["type"] == "ack"


def test_after_kill_9_of_the_program_all_but_the_last_second_is_there(tmp_path):
    options = ("--robot", "kinematic", "--map", "stub", "--record", str(tmp_path))
    with serving(*options) as server:
        with server.live() as live:
            until(live, lambda now: now["recording"]["duration_s"] > 2)
        killed_ns = time.time_ns()
        server.process.kill()
        server.process.wait(10)
    reader = open_recording(next(tmp_path.iterdir()))
    assert reader.unfinished
    assert reader.end_ns > killed_ns - 1_000_000_000
    assert {m.topic for m in reader.messages()} >= {"/scan", "/joint_states", "/map", "/tf_static"}
