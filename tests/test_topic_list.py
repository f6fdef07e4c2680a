"""Which topics there are, and how each is offered."""

import pytest

from app.ros2.topic import UNCHANGING
from app.ros2.topics import TOPICS, topic


def test_only_what_others_publish_is_not_live():
    assert {one.name for one in TOPICS if not one.live} == {"cmd_vel", "initialpose", "command"}


def test_who_comes_late_gets_what_stays():
    latched = {one.name for one in TOPICS if one.quality.latched}
    assert latched == {"map", "tf_static", "amcl_pose", "robot_description"}
    assert topic("map").stamp(None) == UNCHANGING  # type: ignore[arg-type]


def test_an_unknown_topic_is_answered_with_those_there_are():
    with pytest.raises(KeyError, match="valid are scan, odom"):
        topic("laser")
