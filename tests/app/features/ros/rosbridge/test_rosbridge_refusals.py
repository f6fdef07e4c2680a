"""What a client may not do to rosbridge, and what it is told then."""

import json
import re
import tracemalloc

import pytest
from engine_runs import run
from rosbridge_sessions import deliver

from app.engine.drivers import Driver
from app.features.ros.rosbridge.requests import LONGEST, MOST_REQUESTS
from app.features.ros.rosbridge.session import RosbridgeSession

SCAN = "sensor_msgs/msg/LaserScan"


@pytest.mark.parametrize(
    ("op", "request_", "words"),
    [
        ("fly", {}, "'fly' is no operation here; valid are advertise, "),
        ("subscribe", {}, "topic is None; valid is a text"),
        ("subscribe", {"topic": "/wrong"}, "/wrong is no topic; valid are /scan, "),
        ("subscribe", {"topic": "/scan", "type": "a/B"}, f"scan has the type {SCAN}, not a/B"),
        ("subscribe", {"topic": "/scan", "compression": "zip"}, "valid are none, png, cbor"),
        ("subscribe", {"topic": "/scan", "compression": ["png"]}, "valid are none, png, cbor"),
        ("subscribe", {"topic": "/scan", "throttle_rate": -1}, "throttle_rate is -1; valid is 0"),
        ("subscribe", {"topic": "/scan", "throttle_rate": 1e300}, "valid is 0 to 86400000"),
        ("subscribe", {"topic": "/scan", "throttle_rate": float("nan")}, "is nan; valid is 0"),
        ("subscribe", {"topic": "/scan", "queue_length": 10**400}, "a very large number; valid"),
        ("subscribe", {"topic": "/scan", "queue_length": "all"}, "queue_length is 'all'"),
        ("unsubscribe", {"topic": "/scan"}, "/scan is not subscribed"),
        ("advertise", {"topic": "/goal", "type": "a/B"}, "nobody listens to /goal; valid are"),
        (
            "advertise",
            {"topic": "/cmd_vel", "type": "geometry_msgs/Twist"},
            "Stamped.*vel = false",
        ),
        ("publish", {"topic": "/scan", "msg": {}}, "nobody listens to /scan; valid are /cmd_vel"),
        ("set_level", {"level": "all"}, "valid are none, error, warning, info"),
        ("advertise_service", {"service": "/a"}, "no operation here"),
        ("fragment", {"num": 0, "total": 2}, "needs id, num, total and data"),
        ("fragment", {"data": "x"}, "num and total are whole numbers"),
        ("fragment", {"data": "x", "num": 3, "total": 2}, "fragment 3 of 2"),
    ],
)
def test_what_cannot_be_done_is_answered_with_what_can(client, op, request_, words):
    assert re.search(words, client.refused(op, id="mine", **request_))


def test_a_status_has_the_id_and_may_be_switched_off(client):
    assert client.ask("fly", id="mine")[0]["id"] == "mine"
    assert client.ask("set_level", level="none") == []
    assert client.ask("fly") == []
    client.ask("set_level", level="warning")
    assert len(client.ask("fly")) == 1


def test_who_asks_for_no_status_gets_none_and_the_log_tells(bridge, caplog):
    session = RosbridgeSession(bridge, lambda: None, Driver.numbered("rosbridge"))
    refused = '{"op": "publish", "topic": "/goal", "msg": {}}'
    assert session.receive(refused) == []
    assert "nobody listens to /goal; valid are /cmd_vel" in caplog.text
    assert session.receive('{"op": "set_level", "level": "error"}') == []
    (answer,) = session.receive(refused)
    assert json.loads(answer)["op"] == "status"
    session.close()


def test_authentication_is_not_asked_for(client):
    assert client.ask("auth", mac="x") == []


@pytest.mark.parametrize(
    "data",
    [
        "",
        "[" * 100_000,
        '{"op":' * 50_000,
        b"\x00\xff\xfe",
        b"\x89PNG",
        '{"op": 3}',
        "[]",
        "null",
        '{"op": "publish", "topic": "/cmd_vel", "msg": ' + "9" * 5000 + "}",
        "x" * (LONGEST + 1),
        b"x" * (LONGEST + 1),
        '{"op": "subscribe", "topic": "\\ud800"}',
        '{"op": "subscribe", "topic": "' + "x" * 1000 + '"}',
        '{"op": "' + "x" * 1000 + '"}',
    ],
)
def test_hostile_messages_get_a_short_answer(client, data):
    (answer,) = client.send(data)
    assert answer["op"] == "status"
    assert len(answer["msg"]) < 500


def test_ever_more_subscriptions_fill_no_memory(bridge, program, client):
    answers = [
        len(client.ask("subscribe", topic="/odom", id=f"{number}")) for number in range(20_000)
    ]
    assert answers == [0] * MOST_REQUESTS + [1] * (20_000 - MOST_REQUESTS)
    deliver(bridge, program)
    assert len(client.got()) == 1
    assert client.ask("unsubscribe", topic="/odom") == []
    assert client.ask("subscribe", topic="/odom") == []


def test_fragments_without_an_end_fill_no_memory(client):
    tracemalloc.start()
    for number in range(500):
        client.ask("fragment", id=number, num=0, total=1000, data="x" * 100_000)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < 10e6


@pytest.mark.slow
def test_a_client_that_takes_nothing_fills_no_memory(bridge, program, client):
    client.ask("subscribe", topic="/camera/image/compressed", queue_length=10_000, every=True)
    shown = run(program, 0.5)
    tracemalloc.start()
    for _ in range(100):
        bridge.publisher.deliver(*shown)
    kept, _ = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert kept < 25e6
    assert client.got()
