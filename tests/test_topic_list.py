"""Which topics there are, and how each is offered."""

from ros_messages import topic

from app.ros2.topic import UNCHANGING
from app.ros2.topics import TOPICS


def test_only_what_others_publish_is_not_live():
    assert {one.name for one in TOPICS if not one.live} == {"cmd_vel", "initialpose", "command"}


def test_who_comes_late_gets_what_stays():
    latched = {one.name for one in TOPICS if one.quality.latched}
    assert latched == {"map", "tf_static", "amcl_pose", "robot_description"}
    assert topic("map").stamp(None) == UNCHANGING  # type: ignore[arg-type]
