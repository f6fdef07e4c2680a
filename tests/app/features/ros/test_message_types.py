"""The types of ROS messages, as others are told of them."""

import pytest
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from app.features.ros.message_types import definition, typestore
from app.features.ros.topics import TOPICS

TYPES = {one.type for one in TOPICS if not one.only_dds} | {"std_msgs/msg/Float64"}
"""Of the topics of actions over DDS, nobody is told the definition."""


@pytest.mark.parametrize("kind", sorted(TYPES))
def test_each_type_is_defined_for_those_who_do_not_know_it(kind):
    read = get_types_from_msg(definition(kind), kind)
    assert kind in read
    assert read == {name: typestore().fielddefs[name] for name in read}
    # Nothing that it is made of is left out.
    stranger = get_typestore(Stores.EMPTY)
    stranger.register(read)
    stranger.generate_msgdef(kind, ros_version=2)
