"""What everybody gets who asked for all of it."""

from engine_runs import kinematic

from app.engine.mailboxes.broadcast import Broadcast
from app.messages.commands import ScatterCommand


def waiting(feed) -> list:
    found = []
    while (value := feed.get(0)) is not None:
        found.append(value)
    return found


def test_every_subscriber_gets_every_value_in_its_order():
    broadcast = Broadcast[int]()
    with broadcast.subscribe(10) as one, broadcast.subscribe(10) as other:
        for value in range(1, 6):
            broadcast.put(value)
        assert waiting(one) == waiting(other) == [1, 2, 3, 4, 5]


def test_nothing_comes_from_before_or_after_the_subscription():
    broadcast = Broadcast[int]()
    broadcast.put(1)
    with broadcast.subscribe(10) as feed:
        broadcast.put(2)
    broadcast.put(3)
    assert waiting(feed) == [2]


def test_a_slow_subscriber_loses_the_newest_and_knows_how_many():
    broadcast = Broadcast[int]()
    with broadcast.subscribe(3) as slow, broadcast.subscribe(10) as quick:
        for value in range(1, 6):
            broadcast.put(value)
        assert (waiting(slow), slow.lost) == ([1, 2, 3], 2)
        assert (waiting(quick), quick.lost) == ([1, 2, 3, 4, 5], 0)


def test_each_tick_and_the_commands_taken_in_it_are_handed_on():
    engine = kinematic().engine
    with engine.every.subscribe(10) as feed:
        steps = [engine.step()]
        engine.commands.put(ScatterCommand(type="scatter"))
        steps += [engine.step(), engine.step()]
        got = waiting(feed)
    assert got == steps
    assert [[one.type for one in tick.commands] for tick in got] == [[], ["scatter"], []]
    assert [tick.reading.stamp for tick in got] == [tick.stamp for tick in steps]
