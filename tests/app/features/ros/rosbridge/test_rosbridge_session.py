"""The rosbridge protocol, operation by operation."""

import base64
import json

import cv2
import numpy as np
import pytest
from cbor2 import CBORTag
from engine_runs import kinematic, run
from rosbridge_sessions import Client, bridge_of, deliver

from app.features.ros.message_types import from_cdr
from app.messages.driving_commands import StopCommand
from app.settings.groups import Ros2Settings

SCAN = "sensor_msgs/msg/LaserScan"


def test_a_topic_comes_as_json_by_the_name_it_was_asked_for(bridge, program, client):
    assert client.ask("subscribe", topic="/scan", type="sensor_msgs/LaserScan") == []
    (snapshot,) = run(program, 0.02)
    bridge.publisher.deliver(snapshot)
    (message,) = client.got()
    assert (message["op"], message["topic"]) == ("publish", "/scan")
    told = [np.inf if value is None else value for value in message["msg"]["ranges"]]
    expected = np.asarray(snapshot.filter.line_scan.scan.ranges, np.float32)
    assert np.array_equal(np.asarray(told, np.float32), expected)
    assert message["msg"]["header"]["frame_id"] == "base_scan"
    assert client.woken == 1


@pytest.mark.parametrize("name", ["odom", "/odom", "/rover/odom", "rover/odom"])
def test_names_may_have_the_slash_and_the_namespace(name):
    program = kinematic(ros2=Ros2Settings(namespace="rover"))
    bridge = bridge_of(program)
    client = Client(bridge)
    assert client.ask("subscribe", topic=name) == []
    deliver(bridge, program)
    assert [message["topic"] for message in client.got()] == [name]
    assert "/rover/odom" in client.call("/rosapi/topics")[1]["topics"]


def test_cbor_has_typed_arrays_and_bytes(bridge, program, client):
    client.ask("subscribe", topic="/scan", compression="cbor")
    client.ask("subscribe", topic="/camera/image/compressed", compression="cbor")
    deliver(bridge, program, 0.1)
    messages = {message["topic"]: message["msg"] for message in client.got()}
    ranges = messages["/scan"]["ranges"]
    assert isinstance(ranges, CBORTag)
    assert ranges.tag == 85
    assert len(np.frombuffer(ranges.value, "<f4")) > 10
    assert messages["/camera/image/compressed"]["data"][:2] == b"\xff\xd8"


def test_cbor_raw_has_the_bytes_that_ros_has_and_their_time(bridge, program, client):
    client.ask("subscribe", topic="/odom", compression="cbor-raw")
    (snapshot,) = run(program, 0.02)
    bridge.publisher.deliver(snapshot)
    (message,) = client.got()
    odom = from_cdr(message["msg"]["bytes"], "nav_msgs/msg/Odometry")
    assert odom.pose.pose.position.x == pytest.approx(snapshot.odom_from_robot.x)
    told = message["msg"]["secs"] * 10**9 + message["msg"]["nsecs"]
    assert told == bridge.publisher.source.clock.ns(snapshot.stamp)


def test_png_is_the_json_as_a_picture(bridge, program, client):
    client.ask("subscribe", topic="/tf_static", compression="png")
    deliver(bridge, program)
    (message,) = client.got()
    assert message["op"] == "png"
    data = np.frombuffer(base64.b64decode(message["data"]), np.uint8)
    pixels = cv2.imdecode(data, cv2.IMREAD_COLOR)[:, :, ::-1]
    inner = json.loads(pixels.tobytes())
    assert (inner["op"], inner["topic"]) == ("publish", "/tf_static")


def test_what_is_latched_comes_to_who_is_late_and_again_to_a_new_request(bridge, program, client):
    deliver(bridge, program, 0.1)
    for expected in (["/map"], []):
        client.ask("subscribe", topic="/map", id="a")
        deliver(bridge, program, 0.1)
        assert [message["topic"] for message in client.got()] == ["/map"], expected
        deliver(bridge, program, 0.1)
        assert client.got() == []


def test_throttle_rate_holds_back(bridge, program, client):
    client.ask("subscribe", topic="/odom", throttle_rate=100, queue_length=100)
    deliver(bridge, program, 1.0)
    assert len(client.got()) == pytest.approx(10, abs=1)


def test_without_a_queue_only_the_newest_waits(bridge, program, client):
    client.ask("subscribe", topic="/odom")
    shown = run(program, 1.0)
    bridge.publisher.deliver(*shown)
    (message,) = client.got()
    stamp = message["msg"]["header"]["stamp"]
    assert stamp["sec"] * 10**9 + stamp["nanosec"] >= bridge.publisher.source.clock.ns(
        shown[-4].stamp
    )


def test_a_queue_keeps_the_last_in_their_order(bridge, program, client):
    client.ask("subscribe", topic="/odom", queue_length=5)
    deliver(bridge, program, 1.0)
    stamps = [message["msg"]["header"]["stamp"] for message in client.got()]
    times = [stamp["sec"] + stamp["nanosec"] / 1e9 for stamp in stamps]
    assert len(times) == 5
    assert np.diff(times) == pytest.approx(0.05, abs=0.011)


def test_a_recording_may_have_all_that_there_is(bridge, program, client):
    client.ask("subscribe", topic="/odom", queue_length=1000, every=True)
    client.ask("subscribe", topic="/cmd_vel", queue_length=1000, every=True)
    shown = run(program, 1.0)
    bridge.publisher.deliver(*shown)
    topics = [message["topic"] for message in client.got()]
    assert topics.count("/odom") == topics.count("/cmd_vel") == len(shown)


def test_while_a_client_records_the_clock_keeps_its_distances(bridge, client):
    clock = bridge.publisher.source.clock
    before = clock._holders
    client.ask("subscribe", topic="/odom")
    assert clock._holders == before
    client.ask("subscribe", topic="/odom", id="record", every=True)
    client.ask("subscribe", topic="/scan", id="record", every=True)
    assert clock._holders == before + 1
    client.session.close()
    assert clock._holders == before


def test_a_topic_that_comes_often_holds_no_other_up(bridge, program, client):
    client.ask("subscribe", topic="/odom", queue_length=1000)
    client.ask("subscribe", topic="/map")
    deliver(bridge, program, 1.0)
    assert "/map" in [message["topic"] for message in client.got()[:2]]


def test_the_same_text_goes_to_all_who_want_it_alike(bridge, program):
    clients = [Client(bridge) for _ in range(3)]
    for client in clients:
        client.ask("subscribe", topic="/odom")
    deliver(bridge, program)
    first, second, third = (client.session.next() for client in clients)
    assert first is second is third


def test_requests_of_one_client_share_a_stream_until_the_last_has_ended(bridge, program, client):
    client.ask("subscribe", topic="/odom", id="a", throttle_rate=1000)
    client.ask("subscribe", topic="/odom", id="b", queue_length=100)
    deliver(bridge, program, 0.5)
    assert len(client.got()) == 1  # no queue is the shorter one
    client.ask("unsubscribe", topic="/odom", id="a")
    deliver(bridge, program, 0.5)
    assert len(client.got()) == pytest.approx(10, abs=1)
    client.ask("unsubscribe", topic="/odom", id="b")
    deliver(bridge, program, 0.5)
    assert client.got() == []
    assert bridge.publisher._routes == ()


def test_who_left_gets_nothing_more(bridge, program, client):
    client.ask("subscribe", topic="/odom")
    client.session.close()
    deliver(bridge, program, 0.2)
    assert client.got() == []


STAMPED = {"twist": {"linear": {"x": 0.1}}}


def test_a_client_drives_and_when_it_leaves_the_robot_stops(bridge, program, client):
    client.ask("advertise", topic="/cmd_vel", type="geometry_msgs/TwistStamped")
    assert client.ask("publish", topic="/cmd_vel", msg=STAMPED) == []
    assert run(program, 0.3)[-1].twist.v == pytest.approx(0.1)
    client.ask("publish", topic="/cmd_vel", msg=STAMPED)
    client.session.close()
    shown = run(program, 0.3)
    assert StopCommand(type="stop") in shown[0].commands
    assert shown[-1].twist.v == 0


def test_a_client_that_did_not_drive_may_leave(bridge, program, client):
    client.ask("publish", topic="/cmd_vel", msg=STAMPED)
    Client(bridge).session.close()
    assert run(program, 0.1)[-1].mode == "drive"


def test_one_of_two_drivers_may_leave(bridge, program, client):
    other = Client(bridge)
    for driver in (client, other):
        driver.ask("publish", topic="/cmd_vel", msg=STAMPED)
    other.session.close()
    assert run(program, 0.1)[-1].mode == "drive"


@pytest.mark.parametrize("x", ["fast", None, 1e9, [1]])
def test_what_is_refused_on_cmd_vel_stops_the_robot(bridge, program, client, x):
    client.ask("publish", topic="/cmd_vel", msg=STAMPED)
    run(program, 0.2)
    words = client.refused("publish", topic="/cmd_vel", msg={"twist": {"linear": {"x": x}}})
    assert "valid is" in words or "less than" in words
    assert "\n" not in words
    assert run(program, 0.2)[-1].twist.v == 0


def test_a_message_may_come_in_fragments(program, client):
    whole = json.dumps({"op": "publish", "topic": "/cmd_vel", "msg": STAMPED})
    pieces = [whole[:20], whole[20:50], whole[50:]]
    for number in (2, 0, 1):
        answers = client.ask("fragment", id="f", num=number, total=3, data=pieces[number])
        assert answers == []
    assert run(program, 0.02)[0].commands[0].v == 0.1
