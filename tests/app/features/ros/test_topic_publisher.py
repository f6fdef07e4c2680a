"""Who gets which message when, and that a broken route breaks nothing else."""

import queue
import threading
from dataclasses import replace

import pytest
from engine_runs import EIGHT, kinematic, run
from hypothesis import given
from hypothesis import strategies as st
from ros_messages import topic

from app.engine.plugging import plug_in, plugged
from app.feature import Feature
from app.features.ros.doctor_check import check_topics
from app.features.ros.message_types import MessageError
from app.features.ros.publisher import Pace, TopicPublisher, TopicRoute
from app.features.ros.source import RosClock, TopicSource
from app.features.ros.topics import TOPICS, UNCHANGING, Topic, topic_failures, topics
from app.settings.config import Config
from robot.worker_thread import WorkerThread

ODOM, MAP = topic("odom"), topic("map")


class Collecting(TopicRoute):
    """A route that keeps what it gets."""

    name = "collecting"

    def __init__(self, *names: str, period: float = 0.0) -> None:
        self.names = set(names)
        self.got: queue.SimpleQueue = queue.SimpleQueue()
        self._pace = Pace(lambda topic: period)

    def wants(self, topic, stamp):
        return topic.name in self.names and self._pace.due(topic, stamp)

    def take(self, published):
        self.got.put(published)

    def next(self):
        return self.got.get(timeout=10)


@pytest.fixture(scope="module")
def program():
    return kinematic()


@pytest.fixture
def publisher(program):
    publisher = TopicPublisher(TopicSource.of(program), program.engine.every)
    yield publisher
    publisher.close()


def taken(pace: Pace, stamps, topic=ODOM) -> list[float]:
    return [stamp for stamp in stamps if pace.due(topic, stamp)]


@given(st.integers(1, 200), st.integers(1, 60))
def test_a_rate_is_met_on_average_whatever_the_ticks(hertz, ticks_hz):
    stamps = [count / ticks_hz for count in range(20 * ticks_hz)]
    found = taken(Pace(lambda topic: 1 / hertz), stamps)
    expected = min(hertz, ticks_hz) * 20
    assert expected * 0.93 - 1 <= len(found) <= expected * 1.06 + 1


def test_the_same_content_is_taken_once():
    assert taken(Pace(lambda topic: 0.0), [1.0, 1.0, 1.0, 1.1, 1.1]) == [1.0, 1.1]
    assert taken(Pace(lambda topic: 0.0), [UNCHANGING] * 5, MAP) == [UNCHANGING]


def test_a_clock_that_jumps_back_starts_afresh():
    pace = Pace(lambda topic: 1.0)
    assert taken(pace, [10.0, 10.5, 3.0, 3.5, 4.0]) == [10.0, 3.0, 4.0]


def test_after_a_pause_nothing_is_made_up_for():
    pace = Pace(lambda topic: 0.1)
    assert taken(pace, [0.0, 5.0, 5.02, 5.04, 5.1]) == [0.0, 5.0, 5.1]


def test_each_topic_has_its_own_pace():
    pace = Pace(lambda topic: 1.0)
    assert pace.due(ODOM, 1.0)
    assert pace.due(topic("tf"), 1.0)


def test_routes_get_what_they_want_and_share_the_message(program, publisher):
    one, other = Collecting("odom", "map"), Collecting("odom")
    publisher.add(one)
    publisher.add(other)
    run(program, 0.1, EIGHT)
    mine, theirs = one.next(), other.next()
    while mine.stamp != theirs.stamp or mine.topic is not ODOM:
        if mine.topic is not ODOM or mine.stamp < theirs.stamp:
            mine = one.next()
        else:
            theirs = other.next()
    assert mine is theirs


def test_a_late_comer_gets_the_map(program, publisher):
    first = Collecting("odom")
    publisher.add(first)
    run(program, 0.1)
    first.next()
    late = Collecting("map")
    publisher.add(late)
    run(program, 0.04)
    assert late.next().topic is MAP


def test_a_broken_route_ends_alone_and_says_why(program, publisher):
    class Broken(Collecting):
        name = "broken route"

        def take(self, published):
            raise RuntimeError("no space left")

    well = Collecting("odom")
    publisher.add(Broken("odom"))
    publisher.add(well)
    run(program, 0.1)
    before = well.next()
    run(program, 0.1)
    assert well.next().stamp > before.stamp
    (failure,) = publisher.failures
    assert failure.startswith("broken route failed: RuntimeError: no space left (")


def test_a_message_that_a_route_cannot_encode_costs_that_message_alone(program, publisher):
    class Encoding(Collecting):
        def take(self, published):
            if published.topic is ODOM:
                raise MessageError("no odometry")
            super().take(published)

    route = Encoding("odom", "joint_states")
    publisher.add(route)
    run(program, 0.1)
    before = route.next()
    run(program, 0.1)
    assert route.next().stamp > before.stamp
    assert publisher.failures == ("odom failed: no odometry",)


def test_a_topic_that_cannot_be_made_ends_no_route(program, publisher, monkeypatch):
    def impossible(source, snapshot):
        raise ZeroDivisionError("nobody thought of this")

    broken = replace(ODOM, make=impossible)
    monkeypatch.setattr(
        "app.features.ros.publisher.topics",
        lambda: tuple(broken if one is ODOM else one for one in TOPICS),
    )
    route = Collecting("odom", "joint_states")
    publisher.add(route)
    run(program, 0.1)
    assert route.next().topic.name == "joint_states"
    (failure,) = publisher.failures
    assert failure.startswith("odom failed: ZeroDivisionError: nobody thought of this (")


def test_the_thread_is_there_only_while_a_route_is(program, publisher):
    def threads():
        return [one for one in threading.enumerate() if one.name == "topics" and one.is_alive()]

    assert not threads()
    route = Collecting("odom")
    publisher.add(route)
    (thread,) = threads()
    publisher.remove(route)
    thread.join(5)
    assert not threads()


def test_the_next_tick_counts_though_the_thread_has_not_begun(program, publisher, monkeypatch):
    begin = threading.Event()
    waits = WorkerThread._run
    monkeypatch.setattr(WorkerThread, "_run", lambda self: begin.wait(10) and waits(self))
    route = Collecting("odom")
    publisher.add(route)
    snapshot = program.engine.step()
    begin.set()
    assert route.next().stamp == ODOM.stamp(snapshot)


@pytest.mark.slow
def test_who_leaves_and_comes_back_is_never_asked_by_two_threads(program, publisher):
    class Asked(Collecting):
        last = None

        def wants(self, topic, stamp):
            self.last = topic if super().wants(topic, stamp) else None
            return self.last is not None

        def take(self, published):
            self.got.put(published.topic is self.last)

    route = Asked(*(one.name for one in TOPICS))
    for _ in range(100):
        publisher.add(route)
        program.engine.step()
        publisher.remove(route)
        publisher.add(route)
        run(program, 0.04)
        publisher.remove(route)
    publisher.close()
    taken = [route.got.get() for _ in range(route.got.qsize())]
    assert taken
    assert all(taken)


def test_what_waits_is_bounded_and_what_is_lost_is_counted(program, publisher):
    held, go = threading.Event(), threading.Event()

    class Slow(Collecting):
        def take(self, published):
            held.set()
            go.wait(10)

    publisher.add(Slow("odom"))
    run(program, 0.04)
    assert held.wait(10)
    snapshot = program.engine.latest.get()
    for _ in range(700):
        program.engine.every.put(snapshot)
    after = Collecting("odom")
    publisher.add(after)
    go.set()
    after.next()
    assert publisher.lost >= 190


def test_ros_time_keeps_distances_and_follows_a_clock_that_was_set(program, monkeypatch):
    clock = RosClock()
    snapshot = program.engine.step()
    now = 1_700_000_000_000_000_000
    monkeypatch.setattr("app.features.ros.source.time.time_ns", lambda: now)
    monkeypatch.setattr("app.features.ros.source.time.monotonic", lambda: 100.0)

    def follow(stamp, published):
        clock.follow(replace(snapshot, stamp=stamp, published=published))

    follow(5.0, 100.0)
    assert clock.ns(5.0) == now
    follow(5.1, 99.95)  # 0.15 s too late: within what scheduling does
    assert clock.ns(5.1) == now + 100_000_000
    now += 3600 * 10**9
    follow(5.2, 100.0)
    assert clock.ns(5.2) == now
    clock.hold()
    now += 3600 * 10**9
    follow(5.3, 100.0)
    assert clock.ns(5.3) == now - 3600 * 10**9 + 100_000_000
    clock.release()
    follow(5.4, 100.0)
    assert clock.ns(5.4) == now


def test_a_clock_that_was_set_between_two_recordings_is_seen_by_the_second(program, monkeypatch):
    clock = RosClock()
    snapshot = program.engine.step()
    now, here = 1_700_000_000_000_000_000, 100.0
    monkeypatch.setattr("app.features.ros.source.time.time_ns", lambda: now)
    monkeypatch.setattr("app.features.ros.source.time.monotonic", lambda: here)
    clock.hold()
    clock.follow(replace(snapshot, stamp=5.0, published=here))
    clock.release()
    now, here = now + 3600 * 10**9, here + 60  # nobody listens meanwhile
    clock.hold()
    clock.follow(replace(snapshot, stamp=65.0, published=here))
    assert clock.ns(65.0) == now
    clock.hold()  # a second one, who comes late, changes nothing
    here += 60
    clock.hold()
    assert clock.ns(65.0) == now


def test_topics_of_features_that_fail_are_named_once_and_left_out(caplog):
    asked = {"a": 0, "b": 0}

    def broken(name):
        def stamp(snapshot):
            asked[name] += 1
            return {}[name]

        return Topic(name, "std_msgs/msg/Float64", stamp, lambda source, snapshot: None)

    before = plugged().features
    lamps = Feature(name="lamps", about="", topics=(lambda: [broken("a"), broken("b")],))
    plug_in(before.adding(lamps))
    try:
        program = kinematic()
        publisher = TopicPublisher(TopicSource.of(program), program.engine.every)
        publisher.add(Collecting("odom", "a", "b"))
        for snapshot in run(program, 0.2):
            for each in topics():
                publisher.publish(each, snapshot)
        publisher.close()
    finally:
        plug_in(before)
    for name, failure in zip("ab", publisher.failures, strict=True):
        words = f"The topic {name} of the feature lamps is left out: KeyError: '{name}' ("
        assert failure.startswith(words)
        assert asked[name] <= 2  # the thread may ask at the same time
    assert len(caplog.records) <= 4


def test_a_topic_of_an_unknown_type_costs_its_feature_the_topics():
    before = plugged().features
    made, others = Topic("lamp", "std_msgs/msg/Lamp", lambda _: 0.0, lambda *_: None), topics()
    plug_in(before.adding(Feature(name="lamps", about="", topics=(lambda: [made],))))
    try:
        assert topics() == others
        (failure,) = topic_failures()
        (finding,) = check_topics(Config())
    finally:
        plug_in(before)
    assert "lamps cannot be used: std_msgs/msg/Lamp is an unknown type; valid are" in failure
    assert (finding.level, finding.message) == ("problem", failure)
