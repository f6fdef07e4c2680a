"""What the DDS process is told, what passes between it and the program, and its types."""

import json
import subprocess
import sys
from importlib.util import find_spec

import pytest
from dds_rig import own_domain
from engine_runs import kinematic, run
from hypothesis import given
from hypothesis import strategies as st

from app.features.ros.dds import configuration
from app.features.ros.dds.configuration import ALONE, DomainError, domain, plan, reach, shapes
from app.features.ros.dds.protocol import Frames, FramingError, Plan, dds_topic, dds_type, header
from app.features.ros.incoming import INCOMING
from app.features.ros.message_types import to_cdr
from app.features.ros.source import TopicSource
from app.features.ros.topics import TOPICS
from app.settings.config import ROOT
from app.settings.groups import Ros2Settings

needs_cyclone = pytest.mark.skipif(find_spec("cyclonedds") is None, reason="no cyclonedds")
LIVE = [one for one in TOPICS if one.live]

FRAMES = st.lists(st.tuples(st.integers(0, 0xFFFF), st.binary(max_size=30)), max_size=8)


@given(FRAMES, st.lists(st.integers(1, 40), max_size=30))
def test_messages_are_put_together_however_they_are_cut(sent, cuts):
    stream = b"".join(header(number, payload) + payload for number, payload in sent)
    frames, came = Frames(30), []
    for cut in [*cuts, len(stream)]:
        came += frames.feed(stream[:cut])
        stream = stream[cut:]
    assert came == sent


def test_a_message_that_is_too_long_is_refused_at_its_first_bytes():
    with pytest.raises(FramingError, match="a message of 31 bytes; at most 30 are valid"):
        list(Frames(30).feed(header(0, bytes(31))))


def test_names_in_dds_are_those_of_ros():
    assert dds_topic("/robot1/scan") == "rt/robot1/scan"
    assert dds_type("sensor_msgs/msg/LaserScan") == "sensor_msgs::msg::dds_::LaserScan_"


@pytest.mark.parametrize(
    "setting, environment, expected",
    [
        (-1, {}, 0),
        (-1, {"ROS_DOMAIN_ID": "7"}, 7),
        (-1, {"ROS_DOMAIN_ID": ""}, 0),
        (3, {"ROS_DOMAIN_ID": "7"}, 3),
    ],
)
def test_the_domain_is_the_settings_or_else_the_environments(setting, environment, expected):
    assert domain(Ros2Settings(domain_id=setting), environment) == expected


@pytest.mark.parametrize("text", ["233", "-1", "x", "1.5", "٣"])
def test_a_domain_that_is_none_is_refused(text):
    with pytest.raises(DomainError, match="valid are 0 to 232"):
        domain(Ros2Settings(), {"ROS_DOMAIN_ID": text})


def test_an_older_cyclone_is_told_nothing_of_the_loopback(monkeypatch):
    monkeypatch.setattr(configuration, "version", lambda name: "0.10.2")
    told, confined = reach("127.0.0.1", {})
    assert confined and "NetworkInterface" not in told and "<Peer address='127.0.0.1'/>" in told


@pytest.mark.parametrize("host", ["127.0.0.1", "127.0.0.5", "::1", "localhost"])
def test_dds_stays_on_this_machine_with_the_page(host):
    assert reach(host, {}) == (ALONE, True)


@pytest.mark.parametrize("host", ["0.0.0.0", "::", "robot.local", "fd00::2"])
def test_dds_is_where_it_likes_when_the_page_is_on_the_network(host):
    assert reach(host, {}) == (None, False)


def test_dds_uses_the_interface_of_the_pages_address():
    configuration, confined = reach("192.168.1.5", {})
    assert "<NetworkInterface address='192.168.1.5'/>" in configuration and not confined


def test_who_configures_cyclone_has_the_say():
    assert reach("127.0.0.1", {"CYCLONEDDS_URI": "file://mine.xml"}) == (None, False)


def test_a_plan_arrives_as_it_was_sent():
    sent = plan(Ros2Settings(namespace="a/b"), "127.0.0.1", INCOMING, {})
    assert Plan.from_json(sent.to_json()).to_json() == sent.to_json()
    assert sent.namespace == "/a/b" and sent.writers[0].topic == "/a/b/scan"
    assert {one.latched for one in sent.writers} == {True, False}
    assert all(one.reliable for one in sent.writers)


def test_parts_of_types_come_before_the_whole():
    known = set()
    for name, fields in shapes(one.type for one in LIVE).items():
        for _, kind in fields:
            inner = kind if isinstance(kind, str) else kind[0]
            assert "/" not in inner or inner in known
        known.add(name)


@pytest.fixture(scope="module")
def made():
    """A message of each topic that a running robot has, in CDR."""
    program = kinematic(map="stub")
    source, snapshots = TopicSource.of(program), run(program, 1.0)
    source.clock.follow(snapshots[-1])
    found = {}
    for one in LIVE:
        for snapshot in snapshots:
            if one.stamp(snapshot) is not None:
                message = one.make(source, snapshot)
                cdr = message if isinstance(message, bytes) else to_cdr(message, one.type)
                found[one.name] = cdr
    return found


@needs_cyclone
@pytest.mark.parametrize("one", LIVE, ids=lambda one: one.name)
def test_cyclones_own_reading_of_the_types_gives_the_same_bytes(made, one):
    from app.features.ros.dds.raw_types import raw_types

    if one.name not in made:
        pytest.skip("this robot has none")
    idl = raw_types(shapes([one.type]))[one.type].__idl__
    again = idl.serialize(idl.deserialize(made[one.name]), use_version_2=False)
    assert again == made[one.name][: len(again)]
    assert len(made[one.name]) - len(again) < 4


LISTENING = """
import json, os, socket, sys
from app.features.ros.dds.participant import _udp_sockets
from app.features.ros.dds.participant import Participant
from app.features.ros.dds.protocol import Plan
participant = Participant(Plan.from_json(sys.stdin.buffer.read()))
told = [one.getsockopt(socket.SOL_SOCKET, socket.SO_BINDTODEVICE, 16) for one in _udp_sockets()]
print(json.dumps([one.decode() for one in told]), flush=True)
os._exit(0)
"""


@needs_cyclone
@pytest.mark.parametrize("host, device", [("127.0.0.1", "lo\0"), ("0.0.0.0", "")])
def test_another_machine_is_heard_only_where_the_page_is_on_the_network(host, device):
    told = plan(Ros2Settings(domain_id=own_domain()), host, INCOMING[:1], {})
    command = [sys.executable, "-c", LISTENING]
    ran = subprocess.run(
        command, input=told.to_json(), cwd=ROOT, stdout=subprocess.PIPE, check=True
    )
    devices = json.loads(ran.stdout)
    assert len(devices) >= 2
    assert set(devices) == {device}


def test_the_process_imports_little():
    listed = "import sys, app.features.ros.dds.process; print(*sys.modules)"
    command = [sys.executable, "-c", listed]
    ran = subprocess.run(command, cwd=ROOT, stdout=subprocess.PIPE, check=True, text=True)
    assert not {"numpy", "rosbags", "pydantic", "app.settings.config"} & set(ran.stdout.split())


def test_the_page_of_ros_2_lists_each_topic_with_its_type_and_quality():
    page = (ROOT / "docs" / "ros2.md").read_text(encoding="utf-8")
    for one in LIVE:
        quality = "latched" if one.quality.latched else "reliable"
        assert f"| `{one.name}` | {one.type} | {quality} |" in page
        assert one.quality.depth == (1 if one.quality.latched else 10)
    for one in (INCOMING[0], INCOMING[2]):
        assert f"| `{one.name}` | {one.type} | in, " in page
