"""Messages to JSON and CBOR and back."""

import base64
import json
import math

import cbor2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from ros_messages import messages

from app.features.ros.message_types import MessageError, new, to_cdr
from app.features.ros.rosbridge.encoding import TAGS, cbor_values, json_values
from app.features.ros.rosbridge.names import full_type
from app.features.ros.rosbridge.reading import message_of

TYPES = [
    "sensor_msgs/msg/LaserScan",
    "nav_msgs/msg/Odometry",
    "nav_msgs/msg/OccupancyGrid",
    "tf2_msgs/msg/TFMessage",
    "sensor_msgs/msg/CompressedImage",
    "sensor_msgs/msg/CameraInfo",
    "sensor_msgs/msg/JointState",
    "sensor_msgs/msg/BatteryState",
    "diagnostic_msgs/msg/DiagnosticArray",
    "nav2_msgs/msg/ParticleCloud",
    "std_msgs/msg/Empty",
    "std_msgs/msg/UInt64MultiArray",
    "nav2_msgs/srv/SetInitialPose_Request",
    "std_srvs/srv/Empty_Request",
]
WITH_TYPE = st.sampled_from(TYPES).flatmap(
    lambda name: messages(name).map(lambda message: (name, message))
)


@settings(max_examples=60)
@given(WITH_TYPE)
def test_the_json_of_a_message_read_back_equals_it(case):
    name, message = case
    text = json.dumps(json_values(message), allow_nan=False)
    assert to_cdr(message_of(json.loads(text), name), name) == to_cdr(message, name)


@settings(max_examples=60)
@given(WITH_TYPE.filter(lambda case: "Empty" not in case[0]))
def test_the_cbor_of_a_message_read_back_equals_it(case):
    name, message = case
    values = cbor2.loads(cbor2.dumps(cbor_values(message)), tag_hook=typed_array)
    assert to_cdr(message_of(values_of_json(values), name), name) == to_cdr(message, name)


def typed_array(tag, *_):
    dtype = {number: name for name, number in TAGS.items()}[tag.tag]
    return np.frombuffer(tag.value, np.dtype(dtype).newbyteorder("<")).tolist()


def values_of_json(value):
    match value:
        case bytes():
            return base64.b64encode(value).decode()
        case dict():
            return {name: values_of_json(one) for name, one in value.items()}
        case list():
            return [values_of_json(one) for one in value]
    return value


@settings(max_examples=60)
@given(st.sampled_from(TYPES).flatmap(lambda name: messages(name, finite=False)))
def test_what_is_not_finite_is_null(message):
    json.dumps(json_values(message), allow_nan=False)


def test_null_is_not_a_number():
    assert math.isnan(message_of({"data": None}, "std_msgs/msg/Float64").data)


def test_what_is_not_there_has_its_default():
    pose = message_of({}, "geometry_msgs/msg/PoseWithCovarianceStamped")
    assert pose.header.frame_id == ""
    assert (pose.pose.pose.orientation.x, pose.pose.pose.orientation.w) == (0.0, 1.0)
    assert pose.pose.covariance.tolist() == [0.0] * 36
    told = message_of({"x": 0.6, "w": 0.8}, "geometry_msgs/msg/Quaternion")
    assert (told.x, told.w) == (0.6, 0.8)


def test_times_of_pages_for_ros_1_are_understood():
    time = message_of({"secs": 3, "nsecs": 4}, "builtin_interfaces/msg/Time")
    assert (time.sec, time.nanosec) == (3, 4)


@pytest.mark.parametrize("seconds", ["sec", "secs"])
@pytest.mark.parametrize("nanoseconds", ["nanosec", "nsec", "nsecs"])
def test_headers_of_pages_for_ros_1_are_understood(seconds, nanoseconds):
    header = {"seq": 7, "stamp": {seconds: 3, nanoseconds: 4}, "frame_id": "base_link"}
    message = message_of({"header": header}, "geometry_msgs/msg/TwistStamped")
    assert (message.header.stamp.sec, message.header.stamp.nanosec) == (3, 4)
    assert message.header.frame_id == "base_link"
    with pytest.raises(MessageError, match=r"header\.sequence is no field"):
        message_of({"header": {"sequence": 7}}, "geometry_msgs/msg/TwistStamped")
    with pytest.raises(MessageError, match="seq is no field"):
        message_of({"seq": 7}, "geometry_msgs/msg/TwistStamped")


def test_bytes_may_be_a_list_or_base64():
    for data in ([1, 2, 255], "AQL/"):
        image = message_of({"data": data}, "sensor_msgs/msg/CompressedImage")
        assert image.data.tolist() == [1, 2, 255]


def test_numbers_of_single_precision_keep_it():
    message = new("std_msgs/msg/Float32", data=0.1)
    assert json_values(message) == {"data": 0.1}


TWIST = "geometry_msgs/msg/TwistStamped"


@pytest.mark.parametrize(
    ("values", "told"),
    [
        ([], "the message is a list with 0 values; valid is an object with header, twist"),
        ({"linear": {}}, "linear is no field of .*TwistStamped; valid are header, twist"),
        ({"twist": {"linear": 3}}, "twist.linear is 3; valid is an object with x, y, z"),
        ({"twist": {"linear": {"x": "fast"}}}, "twist.linear.x is 'fast'; valid is a number"),
        ({"twist": {"linear": {"x": True}}}, "twist.linear.x is True; valid is a number"),
        ({"twist": {"linear": {"x": 10**400}}}, "x is a very large number; valid is a number"),
        ({"header": {"stamp": {"sec": 2**31}}}, "sec is 2147483648; valid is a whole number from"),
        ({"header": {"stamp": {"sec": 1.5}}}, "sec is 1.5; valid is a whole number"),
        ({"header": {"frame_id": 3}}, "frame_id is 3; valid is a text"),
        ({"header": {"frame_id": "\ud800"}}, "frame_id is .*valid is a text"),
        ({"x" * 500: 3}, "x{60}... is no field"),
    ],
)
def test_what_does_not_fit_is_refused_in_words(values, told):
    with pytest.raises(MessageError, match=told):
        message_of(values, TWIST)


@pytest.mark.parametrize(
    ("type_name", "values", "told"),
    [
        ("geometry_msgs/msg/PoseWithCovariance", {"covariance": [1]}, "has 1 values; valid is 36"),
        ("sensor_msgs/msg/CompressedImage", {"data": "?"}, "data is no base64"),
        ("sensor_msgs/msg/CompressedImage", {"data": [256]}, r"data\[0\] is 256; valid .* 255"),
        ("sensor_msgs/msg/LaserScan", {"ranges": 3}, "ranges is 3; valid is a list"),
        ("std_msgs/msg/Bool", {"data": 1}, "data is 1; valid is true or false"),
        ("std_msgs/msg/Wrong", {}, "unknown type; valid are .*std_msgs/msg/Bool"),
    ],
)
def test_other_types_are_as_strict(type_name, values, told):
    with pytest.raises(MessageError, match=told):
        message_of(values, type_name)


JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=4),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=4), inner),
)


@given(st.sampled_from(TYPES), JSON)
def test_anything_is_a_message_or_refused(type_name, values):
    try:
        message_of(values, type_name)
    except MessageError as error:
        assert str(error)


def test_names_of_types_of_ros_1_are_understood():
    assert full_type("geometry_msgs/Twist", "msg") == "geometry_msgs/msg/Twist"
    assert full_type("std_srvs/srv/Empty", "srv") == "std_srvs/srv/Empty"
    assert full_type("nonsense", "msg") == "nonsense"
