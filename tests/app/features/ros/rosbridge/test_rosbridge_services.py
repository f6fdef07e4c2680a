"""Services by rosbridge: those of the robot, and rosapi's."""

import re

import pytest
from engine_runs import run

from app.messages.commands import ScatterCommand, SetPoseCommand

SCAN = "sensor_msgs/msg/LaserScan"


def test_services_are_commands(program, client):
    assert client.call("/reinitialize_global_localization") == (True, {})
    assert client.call("request_nomotion_update", []) == (True, {})
    pose = {"header": {"frame_id": "map"}, "pose": {"pose": {"position": {"x": 0.1}}}}
    assert client.call("/set_initial_pose", {"pose": pose}) == (True, {})
    assert client.call("/set_initial_pose", [pose]) == (True, {})
    taken = run(program, 0.02)[0].commands
    assert {type(command) for command in taken} >= {ScatterCommand, SetPoseCommand}


@pytest.mark.parametrize(
    ("service", "args", "words"),
    [
        ("/fly", {}, "/fly is no service; valid are .*/set_initial_pose.*rosapi/topics"),
        ("/rosapi/fly", {}, "valid are .*rosapi/topics"),
        ("/set_initial_pose", {"poze": 1}, "poze is no field .*valid are pose"),
        ("/set_initial_pose", [1, 2], "takes 1 arguments"),
        ("/set_initial_pose", "x", "valid is an object with pose"),
        ("/rosapi/topic_type", {}, "topic is None; valid is a text"),
        ("/rosapi/message_details", {"type": "a/b"}, "a/msg/b is an unknown type"),
    ],
)
def test_a_service_that_fails_says_why(client, service, args, words):
    result, values = client.call(service, args)
    assert result is False
    assert re.search(words, values)


def test_rosapi_tells_what_there_is(client):
    _, topics = client.call("rosapi/topics")
    types = dict(zip(topics["topics"], topics["types"], strict=True))
    assert types["/scan"] == SCAN
    assert types["/cmd_vel"] == "geometry_msgs/msg/TwistStamped"
    assert client.call("/rosapi/topics") == (True, topics)
    assert client.call("/rosapi/topic_type", {"topic": "/scan"})[1] == {"type": SCAN}
    assert client.call("/rosapi/topic_type", ["scan"])[1] == {"type": SCAN}
    found = client.call("/rosapi/topics_for_type", {"type": "sensor_msgs/LaserScan"})[1]
    assert found == {"topics": ["/scan"]}
    services = client.call("/rosapi/services")[1]["services"]
    assert {"/set_initial_pose", "/rosapi/topics"} <= set(services)
    kind = client.call("/rosapi/service_type", {"service": "/set_initial_pose"})[1]
    assert kind == {"type": "nav2_msgs/srv/SetInitialPose"}
    assert client.call("/rosapi/nodes")[1] == {"nodes": ["/brickpose"]}
    details = client.call("/rosapi/node_details", {"node": "/brickpose"})[1]
    assert "/scan" in details["publishing"]
    assert "/cmd_vel" in details["subscribing"]
    raw = client.call("/rosapi/topics_and_raw_types")[1]
    assert raw["topics"] == topics["topics"]
    assert "float32[] ranges" in raw["typedefs_full_text"][raw["topics"].index("/scan")]
    assert client.call("/rosapi/get_ros_version")[1]["version"] == 2
    assert client.call("/rosapi/get_time")[1]["time"]["sec"] > 1_700_000_000


def test_rosapi_takes_types_apart(client):
    details = client.call("/rosapi/message_details", {"type": "nav_msgs/Odometry"})[1]["typedefs"]
    first = details[0]
    assert first["type"] == "nav_msgs/msg/Odometry"
    assert first["fieldnames"] == ["header", "child_frame_id", "pose", "twist"]
    by_type = {one["type"]: one for one in details}
    covariance = by_type["geometry_msgs/msg/PoseWithCovariance"]
    assert covariance["fieldarraylen"] == [-1, 36]
    request = client.call(
        "/rosapi/service_request_details", {"type": "nav2_msgs/srv/SetInitialPose"}
    )[1]
    assert request["typedefs"][0]["fieldnames"] == ["pose"]
