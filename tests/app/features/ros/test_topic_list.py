"""Which topics there are, and how each is offered."""

from engine_runs import kinematic, run
from ros_messages import topic

from app.features.ros.topics import TOPICS, UNCHANGING


def test_only_what_others_publish_is_not_live():
    assert {one.name for one in TOPICS if not one.live} == {
        "cmd_vel",
        "initialpose",
        "goal_pose",
        "command",
    }


def test_who_comes_late_gets_what_stays():
    latched = {one.name for one in TOPICS if one.quality.latched}
    assert latched == {
        "map",
        "tf_static",
        "amcl_pose",
        "robot_description",
        "navigate_to_pose/_action/status",
    }


def test_the_fields_map_never_changes():
    before, last = run(kinematic(), 0.04)
    assert topic("map").stamp(before) == topic("map").stamp(last) == UNCHANGING
