"""One viewer of Foxglove without its socket: what it wants, sends and is told."""

import json
from contextlib import closing

import pytest
from engine_runs import kinematic
from hypothesis import given
from hypothesis import strategies as st

from app.engine.drivers import Driver, Drivers
from app.features.ros.foxglove.offer import Offer
from app.features.ros.foxglove.protocol import MOST_BYTES
from app.features.ros.foxglove.session import FoxgloveSession
from app.features.ros.inbox import Inbox
from app.features.ros.publisher import TopicPublisher
from app.features.ros.source import TopicSource
from app.features.ros.topics import TOPICS

NOW = {"sec": 0, "nanosec": 0}
ZERO = {"x": 0, "y": 0, "z": 0}


class Viewer:
    """A session without a socket."""

    def __init__(self, offer, refusal=None) -> None:
        self.session = FoxgloveSession(offer, lambda: None, Driver.numbered("Foxglove"), refusal)
        self.close = self.session.close

    def told(self, **words) -> list[dict]:
        return [json.loads(one) for one in self.session.receive(json.dumps(words))]

    def wanted(self) -> list[str]:
        return [one.name for one in TOPICS if self.session.wants(one, 1.0)]


def offer_of(program) -> Offer:
    source = TopicSource.of(program)
    publisher = TopicPublisher(source, program.engine.every)
    return Offer(publisher, Inbox(program, source, Drivers.of(program)))


@pytest.fixture(scope="module")
def offer() -> Offer:
    return offer_of(kinematic())


@pytest.fixture
def viewer(offer):
    with closing(Viewer(offer)) as viewer:
        yield viewer


def test_what_nobody_looks_at_is_not_made(viewer):
    assert viewer.wanted() == []
    assert viewer.told(op="subscribe", subscriptions=[{"id": 7, "channelId": 0}]) == []
    first = viewer.session._offer.topics[0].name
    assert viewer.wanted() == [first]
    viewer.told(op="unsubscribe", subscriptionIds=[7])
    assert viewer.wanted() == []


CHANNEL = {"id": 1, "topic": "/cmd_vel", "encoding": "cdr", "schemaName": "a/B"}


@pytest.mark.parametrize(
    ("request_", "words"),
    [
        ({"op": "fly"}, "'subscribe', 'unsubscribe', 'advertise', 'unadvertise'"),
        ({"op": "subscribe"}, "subscriptions: Field required"),
        ({"op": "subscribe", "subscriptions": [{"id": 0, "channelId": 999}]}, "not among those"),
        ({"op": "subscribe", "subscriptions": [{"id": -1, "channelId": 0}]}, "greater than"),
        ({"op": "subscribe", "subscriptions": [{"id": 1, "channelId": 0}] * 2}, "already"),
        ({"op": "advertise", "channels": [CHANNEL]}, "has the type geometry_msgs"),
        ({"op": "advertise", "channels": [{**CHANNEL, "topic": "/goal"}]}, "nobody listens to"),
    ],
)
def test_what_cannot_be_done_is_answered_in_words(viewer, request_, words):
    (answer,) = viewer.told(**request_)
    assert (answer["op"], answer["level"]) == ("status", 2)
    assert words in answer["message"]


def test_one_wrong_item_does_not_keep_the_others_of_its_list_out(viewer):
    wishes = [{"id": number, "channelId": number} for number in (999, 0, 1)]
    (answer,) = viewer.told(op="subscribe", subscriptions=wishes)
    assert "999" in answer["message"]
    topics = viewer.session._offer.topics
    assert viewer.wanted() == [topics[0].name, topics[1].name]
    right = {**CHANNEL, "id": 2, "schemaName": "geometry_msgs/msg/TwistStamped"}
    (answer,) = viewer.told(op="advertise", channels=[CHANNEL, right])
    assert "has the type geometry_msgs" in answer["message"]
    (answer,) = viewer.session.receive(b"\x01" + (2).to_bytes(4, "little"))
    assert json.loads(answer)["op"] == "status", "its channel is open: no twist is this short"


@pytest.mark.parametrize(
    "data",
    [
        "",
        "[]",
        "[" * 100_000,
        "x" * (MOST_BYTES + 1),
        b"\x01",
        b"\x02\x00\x00\x00\x00",
        b"\x07garbage",
        b"\x02" + bytes(8) + b"\x02\x00\x00\x00\xff\xfe",
    ],
)
def test_hostile_messages_get_a_short_answer(viewer, data):
    (answer,) = viewer.session.receive(data)
    assert len(answer) < 600
    assert json.loads(answer)["op"] == "status"


@given(st.binary(max_size=60) | st.text(max_size=60))
def test_whatever_is_sent_the_session_goes_on(data):
    for answer in SHARED.session.receive(data):
        assert json.loads(answer)["op"] in ("status", "serviceCallFailure")


def test_who_may_not_give_orders_is_told_why(offer):
    with closing(Viewer(offer, "this token only watches")) as viewer:
        for op, items in (("advertise", "channels"), ("unadvertise", "channelIds")):
            (answer,) = viewer.told(op=op, **{items: []})
            assert answer["message"] == "this token only watches"
        (answer,) = viewer.session.receive(b"\x02" + bytes(12))
        assert json.loads(answer)["op"] == "serviceCallFailure"


SHARED = Viewer(offer_of(kinematic()))
