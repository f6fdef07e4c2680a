"""Whatever the frames are called, they are one tree."""

from dataclasses import replace

import pytest
from engine_runs import kinematic, run
from ros_messages import topic

from app.features.ros.source import TopicSource
from robot.settings import SettingError


@pytest.fixture(scope="module")
def program():
    return kinematic()


@pytest.fixture(scope="module")
def source(program):
    return TopicSource.of(program)


@pytest.fixture(scope="module")
def tick(program):
    """One at which the robot knows where it is."""
    found = run(program, 1.0)[-1]
    assert found.pose is not None
    return found


@pytest.mark.parametrize(
    "names",
    [
        {},
        {"base_frame_id": "base_link"},
        {"base_frame_id": "spike"},
        {"scan_frame_id": "base_footprint"},
    ],
)
def test_each_frame_has_one_parent_and_the_map_is_above_all(source, tick, names):
    other = replace(source, settings=replace(source.settings, **names))
    parents = {}
    for made in ("tf", "tf_static"):
        for one in topic(made).make(other, tick).transforms:
            assert one.child_frame_id not in parents
            parents[one.child_frame_id] = one.header.frame_id
    assert set(parents.values()) - set(parents) == {"map"}
    assert parents[other.settings.base_frame_id] == "odom"
    above = {one.child: one for one in other.robot(tick).links.fixed}
    if "base_footprint" in above and "base_link" not in above:
        assert above["base_footprint"].place == pytest.approx((0, 0, -0.028))


@pytest.mark.parametrize(
    "names", [{"base_frame_id": "left_wheel"}, {"base_frame_id": "hub"}, {"scan_frame_id": "hub"}]
)
def test_names_with_which_a_frame_would_have_two_parents_are_refused(source, tick, names):
    other = replace(source, settings=replace(source.settings, **names))
    with pytest.raises(SettingError, match="a name that no link has"):
        _ = other.robot(tick).links
